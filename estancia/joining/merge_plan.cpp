// SPDX-License-Identifier: Apache-2.0
#include "estancia/joining/merge_plan.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {
namespace {

using Sources = std::span<const std::unique_ptr<MapSource>>;

constexpr std::size_t maxPositions = 16;  // positions of a place that are compared
constexpr double elsewhere = 2;           // near distances: further apart, images show two places

/// A place of a map.
struct Place {
  std::size_t map = 0;
  int node = 0;
  auto operator<=>(const Place&) const = default;
};

struct Link {
  Place a, b;
  PlaceLink why;
  /// Surest first.
  auto rank() const { return std::tuple(!why.isSure, why.distance / why.threshold, a, b); }
};

const LinkedMaps* find(const std::vector<LinkedMaps>& linked, std::size_t a, std::size_t b) {
  const std::pair ends(std::min(a, b), std::max(a, b));
  const auto endsOf = [](const LinkedMaps& maps) { return std::pair(maps.first, maps.second); };
  const auto found = std::ranges::lower_bound(linked, ends, {}, endsOf);
  return found == linked.end() || endsOf(*found) != ends ? nullptr : &*found;
}

/// Given order, except that a map without a link to previous ones waits for one that it is linked to.
std::vector<std::size_t> orderOf(std::size_t maps, const std::vector<LinkedMaps>& linked) {
  std::vector<std::set<std::size_t>> neighbors(maps);
  for (const LinkedMaps& pair : linked) {
    neighbors[pair.first].insert(pair.second);
    neighbors[pair.second].insert(pair.first);
  }
  std::vector<std::size_t> order;
  std::set<std::size_t> waiting, reachable;
  for (std::size_t i = 0; i < maps; ++i) waiting.insert(i);
  while (!waiting.empty()) {
    const std::size_t next = reachable.empty() ? *waiting.begin() : *reachable.begin();
    waiting.erase(next);
    reachable.erase(next);
    order.push_back(next);
    for (const std::size_t other : neighbors[next])
      if (waiting.contains(other)) reachable.insert(other);
  }
  return order;
}

/// Places that are one, each group named by one of them (average linkage: of the pairs of places in two
/// groups, half must be linked, or one false link among a hundred maps would join two places of all of them).
class PlaceGroups {
 public:
  PlaceGroups(Sources sources, const std::vector<Link>& links) {
    for (std::size_t map = 0; map < sources.size(); ++map)
      for (const Node& node : sources[map]->map.nodes) {
        const Place place{map, node.id};
        groupOf_[place] = place;
        parts_[place] = {place};
      }
    for (const Link& link : links)
      if (link.why.isSure) {
        linked_[link.a].push_back(link.b);
        linked_[link.b].push_back(link.a);
      }
  }

  /// The groups that the link joins, if it may: none of their places are apart, or of one map. Links that
  /// were found image by image are few, of one map with one other: they need no others beside them.
  std::optional<std::pair<Place, Place>> joinable(
      const Link& link, const std::function<bool(const Place&, const Place&)>& areApart) const {
    const auto a = groupOf_.find(link.a), b = groupOf_.find(link.b);
    if (a == groupOf_.end() || b == groupOf_.end() || a->second == b->second) return std::nullopt;
    const auto &some = parts_.at(a->second), &others = parts_.at(b->second);
    if (link.why.isSure) {
      const bool isSmaller = some.size() <= others.size();
      const std::size_t links = isSmaller ? linksBetween(some, b->second) : linksBetween(others, a->second);
      if (2 * links < some.size() * others.size()) return std::nullopt;
    }
    for (const Place& place : some)
      for (const Place& other : others)
        if (place.map == other.map || areApart(place, other)) return std::nullopt;
    return std::pair(a->second, b->second);
  }

  void join(const Place& kept, const Place& gone) {
    auto others = parts_.extract(gone);
    for (const Place& place : others.mapped()) groupOf_[place] = kept;
    auto& all = parts_.at(kept);
    all.insert(all.end(), others.mapped().begin(), others.mapped().end());
  }

  /// Indexed by place.
  const std::map<Place, Place>& groups() const { return groupOf_; }

 private:
  std::size_t linksBetween(const std::vector<Place>& places, const Place& group) const {
    std::size_t count = 0;
    for (const Place& place : places)
      if (const auto linked = linked_.find(place); linked != linked_.end())
        count += static_cast<std::size_t>(
            std::ranges::count_if(linked->second, [&](const Place& other) { return isIn(other, group); }));
    return count;
  }

  bool isIn(const Place& place, const Place& group) const {
    const auto found = groupOf_.find(place);
    return found != groupOf_.end() && found->second == group;
  }

  std::map<Place, Place> groupOf_;
  std::map<Place, std::vector<Place>> parts_, linked_;
};

/// A map, and the one before it that it shares most places with.
struct Comparison {
  std::size_t reference, map;
  LocalizedMap found = {};
};

/// Plans how maps are joined: their order, transforms and new place numbers. Life cycle: constructed from
/// open maps, then make() once. Invariant: the new number of a place is firstNode of its map plus its old
/// number, so numbers of two maps never collide.
class Planner {
 public:
  Planner(Sources sources, std::vector<LinkedMaps> linked) : sources_(sources), linked_(std::move(linked)) {
    plan_.order = orderOf(sources.size(), linked_);
    plan_.toMerged.resize(sources.size());
    plan_.firstNode.resize(sources.size());
    std::int64_t next = 0;
    for (const std::size_t map : plan_.order) {
      plan_.firstNode[map] = static_cast<int>(next);
      next += nextNodeOf(sources_[map]->map);
      if (next > std::numeric_limits<int>::max())
        fail(ErrorCode::corruptFile, "{} has places with too large numbers; map its drives again",
             sources_[map]->path.string());
    }
    for (const auto& source : sources) hasPoses_.push_back(source->hasPoses());
    nearDistance_ = settingsFromJson(sources[plan_.order.front()]->store.identity().settings).nearDistance;
  }

  MergePlan make(Progress& progress) {
    std::vector<Comparison> comparisons = neededComparisons();
    if (!comparisons.empty()) progress.begin("localizing maps in each other", comparisons.size(), 0);
    inParallel(comparisons.size(), 0, progress, "stopped; nothing was changed", [&](std::size_t i) {
      Comparison& c = comparisons[i];
      c.found = localizeMap(sources_[c.reference]->path, sources_[c.map]->path);
    });
    if (!comparisons.empty()) progress.end();
    findFrames(comparisons);
    joinPlaces(linksOf(comparisons));
    return std::move(plan_);
  }

 private:
  static std::int64_t nextNodeOf(const TopologicalMap& map) {
    std::int64_t last = 0;
    for (const Node& node : map.nodes) last = std::max<std::int64_t>(last, node.id);
    for (const Decision& decision : map.decisions) last = std::max<std::int64_t>(last, decision.node);
    for (const Merge& merge : map.merges) last = std::max<std::int64_t>({last, merge.kept, merge.absorbed});
    return last + 1;
  }

  /// With the map before it that it shares most places with, and with the one of those with poses.
  std::vector<Comparison> neededComparisons() {
    std::vector<Comparison> needed;
    for (auto map = plan_.order.begin(); map != plan_.order.end(); ++map) {
      const auto best = bestReference(*map, map, false), bestPosed = bestReference(*map, map, true);
      if (best) {
        const LinkedMaps& maps = *find(linked_, *best, *map);
        if (best == bestPosed || 2 * maps.sure() < maps.links.size()) needed.push_back({*best, *map});
      }
      if (bestPosed && bestPosed != best) needed.push_back({*bestPosed, *map});
    }
    return needed;
  }

  std::optional<std::size_t> bestReference(std::size_t map, std::vector<std::size_t>::const_iterator end,
                                           bool withPoses) const {
    std::optional<std::size_t> reference;
    std::pair<std::size_t, std::size_t> most;
    for (auto before = plan_.order.begin(); before != end; ++before) {
      const LinkedMaps* maps = find(linked_, *before, map);
      if (maps == nullptr || (withPoses && !arePosed(*before, map))) continue;
      const std::pair count(maps->sure(), maps->links.size());
      if (reference && count <= most) continue;
      reference = *before;
      most = count;
    }
    return reference;
  }

  void findFrames(const std::vector<Comparison>& comparisons) {
    bool isKnown = false;
    for (const std::size_t map : plan_.order) {
      auto& toMerged = plan_.toMerged[map];
      if (!isKnown && hasPoses_[map]) {
        toMerged = cv::Affine3d::Identity();
        isKnown = true;
      }
      for (const Comparison& c : comparisons)
        if (c.map == map && !toMerged && c.found.alignment && plan_.toMerged[c.reference])
          toMerged = *plan_.toMerged[c.reference] * *c.found.alignment;
    }
  }

  /// The sure ones, and those found image by image unless no transform fits both maps' poses; surest first.
  std::vector<Link> linksOf(const std::vector<Comparison>& comparisons) const {
    std::vector<Link> links;
    for (const LinkedMaps& maps : linked_)
      for (const PlaceLink& link : maps.links)
        if (link.isSure) links.push_back({{maps.first, link.a}, {maps.second, link.b}, link});
    for (const Comparison& c : comparisons) {
      if (arePosed(c.reference, c.map) && !c.found.alignment) continue;
      for (const PlaceLink& link : c.found.links)
        links.push_back({{c.reference, link.a}, {c.map, link.b}, link});
    }
    std::ranges::sort(links, {}, &Link::rank);
    return links;
  }

  void joinPlaces(std::vector<Link> links) {
    const auto apart = [this](const Place& a, const Place& b) { return areApart(a, b); };
    std::erase_if(links, [&](const Link& link) { return apart(link.a, link.b); });
    PlaceGroups groups(sources_, links);
    for (const Link& link : links) {
      auto pair = groups.joinable(link, apart);
      if (!pair) continue;
      if (newId(pair->second) < newId(pair->first)) std::swap(pair->first, pair->second);
      groups.join(pair->first, pair->second);
      plan_.merges.push_back(
          {0, newId(pair->first), newId(pair->second), link.why.distance, link.why.threshold});
    }
    for (const auto& [place, kept] : groups.groups())
      if (place != kept) plan_.keptBy[newId(place)] = newId(kept);
  }

  bool arePosed(std::size_t a, std::size_t b) const { return hasPoses_[a] && hasPoses_[b]; }
  int newId(const Place& place) const { return plan_.firstNode[place.map] + place.node; }

  /// Whether poses prove that no images of the two were taken near each other.
  bool areApart(const Place& one, const Place& other) {
    const auto &a = positionsOf(one), &b = positionsOf(other);
    if (a.empty() || b.empty()) return false;
    for (const cv::Point3d& p : a)
      for (const cv::Point3d& q : b)
        if (cv::norm(p - q) <= elsewhere * nearDistance_) return false;
    return true;
  }

  /// In the merged map; none where they are not known there.
  const std::vector<cv::Point3d>& positionsOf(const Place& place) {
    if (positions_.empty())
      for (std::size_t map = 0; map < sources_.size(); ++map) readPositions(map);
    return positions_[place];
  }
  void readPositions(std::size_t map) {
    if (!plan_.toMerged[map]) return;
    for (const MappedFrame& frame : sources_[map]->map.frames)
      if (frame.pose) {
        const cv::Vec3d at = (*plan_.toMerged[map] * rigidOf(*frame.pose)).translation();
        positions_[{map, frame.node}].emplace_back(at[0], at[1], at[2]);
      }
    for (auto own = positions_.lower_bound({map, 0}); own != positions_.end() && own->first.map == map;
         ++own) {
      std::vector<cv::Point3d>& all = own->second;
      const std::size_t count = std::min(all.size(), maxPositions);
      for (std::size_t i = 0; i < count; ++i) all[i] = all[i * all.size() / count];
      all.resize(count);
    }
  }

  Sources sources_;
  std::vector<LinkedMaps> linked_;
  MergePlan plan_;
  std::vector<bool> hasPoses_;
  double nearDistance_ = 0;
  std::map<Place, std::vector<cv::Point3d>> positions_;
};

TopologicalMap asOfNow(MapStore& store) {
  store.beginReading();
  return store.load();
}

}  // namespace

int MergePlan::kept(int node) const {
  const auto found = keptBy.find(node);
  return found == keptBy.end() ? node : found->second;
}

MergePlan planMerge(Sources sources, std::vector<LinkedMaps> linked, Progress& progress) {
  return Planner(sources, std::move(linked)).make(progress);
}

MapSource::MapSource(const std::filesystem::path& file)
    : path(file), store(MapStore::open(file, MapStore::Access::read)), map(asOfNow(store)) {
  layers.emplace(store, MapStore::Access::read);
  if (map.frames.empty())
    fail(ErrorCode::insufficientData, "{} has no frames; map some images first", path.string());
  if (map.nodes.empty())
    fail(ErrorCode::corruptFile, "{} has frames but no places; map the sequence again", path.string());
  isObserved.resize(map.frames.size());
  if (!layers->exists()) return;
  for (const std::size_t frame : layers->observedFrames())
    if (const auto index = map.findFrame(frame)) isObserved[*index] = true;
}

std::optional<Observation> MapSource::observation(std::size_t frame) const {
  return isObserved[frame] ? std::optional(layers->observation(map.frames[frame].number)) : std::nullopt;
}

std::vector<std::size_t> MapSource::numbers(std::size_t first, std::size_t end) const {
  std::vector<std::size_t> numbers;
  for (std::size_t i = first; i < end; ++i) numbers.push_back(map.frames[i].number);
  return numbers;
}

cv::Affine3d MapSource::alignment(std::size_t drive) const {
  const auto& found = map.drives[drive].alignment;
  return found ? rigidOf(*found) : cv::Affine3d::Identity();
}

std::size_t MapSource::end(std::size_t drive) const {
  return drive + 1 < map.drives.size() ? map.drives[drive + 1].firstFrame : map.frames.size();
}

bool MapSource::hasPoses() const {
  return std::ranges::any_of(map.frames, [](const MappedFrame& frame) { return frame.pose.has_value(); });
}

void requireMergeable(const MapSource& first, const MapSource& other) {
  const std::string file = other.path.string();
  requireSameVocabulary(first.map.vocabulary, other.map.vocabulary, file);
  if (first.map.model != other.map.model)
    fail(ErrorCode::mismatch, "{} was made with the model {}, and {} with {}; map both with one model",
         first.path.string(), first.map.model, file, other.map.model);
  if (first.map.distance != other.map.distance)
    fail(ErrorCode::mismatch, "{} compares places by {}, and {} by {}; map both with one --distance",
         first.path.string(), first.map.distance, file, other.map.distance);
  for (std::size_t a = 0; a < first.map.drives.size(); ++a)
    for (std::size_t b = 0; b < other.map.drives.size(); ++b) {
      const std::size_t begin = first.map.drives[a].firstFrame, end = other.map.drives[b].firstFrame;
      const std::size_t frames = first.end(a) - begin;
      if (frames == 0 || other.end(b) - end != frames) continue;
      const auto isSame = [&](std::size_t i) {
        return first.map.frames[begin + i].name == other.map.frames[end + i].name &&
               first.descriptor(begin + i) == other.descriptor(end + i);
      };
      if (isSame(0) && isSame(frames / 2) && isSame(frames - 1))
        fail(ErrorCode::invalidInput,
             "{} and {} have the drive \"{}\" in common; a map cannot be merged with itself: undo the drive "
             "in one of them",
             first.path.string(), file, first.map.drives[a].name);
    }
}

}  // namespace estancia
