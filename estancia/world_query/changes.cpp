// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/objects/instance_map.hpp"
#include "estancia/session/session_impl.hpp"
#include "estancia/stats/moments.hpp"
#include "estancia/world_file/segment_answers.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {
namespace {

constexpr double spotWidth = 0.04;       // [m]
constexpr std::size_t enoughSpots = 10;  // spots of something that changed: 160 cm² of its surface
constexpr std::size_t enoughViews = 2;   // views of a spot in each epoch
constexpr std::int32_t gap = 2;          // spots this far apart are of one thing
constexpr double wholeShare = 0.5;       // share of an object's spots that were looked at
constexpr double sameSize = 1.7;         // ratio of lengths of a thing that was moved
constexpr double enoughAlike = 0.35;     // cosine of the words of one thing in two places

/// Below, a difference in depth is noise: a Kinect's is 0.0012 z² (Khoshelham and Elberink 2012), and poses
/// are off by some centimeters.
double noiseAt(double depth) {
  return 0.03 + 3 * 0.0012 * depth * depth;
}

/// A piece of a surface, as one epoch saw it, and how often the other one saw its place empty or full.
struct Spot {
  cv::Point3d point;
  int object = -1;
  std::size_t views = 0, first = 0, last = 0, empty = 0, full = 0;

  bool isLookedAt() const { return views >= enoughViews && empty + full >= enoughViews; }
  bool isEmpty() const { return isLookedAt() && empty >= enoughViews && empty > 2 * full; }
};
using Spots = std::unordered_map<VoxelKey, Spot, VoxelHash>;

VoxelKey keyOf(const cv::Point3d& point) {
  const auto cell = [](double value) { return static_cast<std::int32_t>(std::floor(value / spotWidth)); };
  return {cell(point.x), cell(point.y), cell(point.z)};
}

/// The surfaces of things in the two epochs of a map: before a frame, and since.
class Epochs {
 public:
  Epochs(const WorldMap& world, const WorldStore& store, std::size_t firstNow)
      : world_(world), store_(store), firstNow_(firstNow) {
    findSpots();
    findLooks();
  }

  /// 0: before, 1: now.
  const Spots& spots(std::size_t epoch) const { return spots_[epoch]; }

 private:
  std::size_t epochOf(std::size_t frame) const { return frame >= firstNow_ ? 1 : 0; }

  void findSpots() {
    const std::map<SegmentPlace, int> objectOf = store_.objectSegments();
    forEachView(
        [&](std::size_t frame, const Observation& seen, const cv::Mat& depth, const cv::Affine3d& pose) {
          if (seen.segments.empty()) return;
          std::vector<int> objects{-1};
          for (std::size_t s = 1; s <= seen.info.size(); ++s) {
            const auto found = objectOf.find({frame, s});
            objects.push_back(found == objectOf.end() ? -1 : found->second);
          }
          for (int y = 0; y < depth.rows; ++y)
            for (int x = 0; x < depth.cols; ++x) {
              const std::size_t segment = seen.segments.at<unsigned char>(y, x);
              const float z = depth.at<float>(y, x);
              if (segment == 0 || segment >= objects.size() || !(z > 0) || z > farthest) continue;
              if (objects[segment] < 0 && seen.info[segment - 1].flat) continue;  // a piece of a wall
              add(pose * cv::Point3d(seen.camera.slopeX(x) * z, seen.camera.slopeY(y) * z, z), frame,
                  objects[segment]);
            }
        });
  }

  void add(const cv::Point3d& point, std::size_t frame, int object) {
    const auto [entry, isNew] = spots_[epochOf(frame)].try_emplace(keyOf(point));
    Spot& spot = entry->second;
    if (isNew) {
      spot.point = point;
      spot.first = frame;
    }
    if (isNew || spot.last != frame) ++spot.views;
    spot.last = frame;
    if (object >= 0) spot.object = object;
  }

  void findLooks() {
    forEachView(
        [&](std::size_t frame, const Observation& seen, const cv::Mat& depth, const cv::Affine3d& pose) {
          const cv::Affine3d inverse = pose.inv();
          for (auto& [key, spot] : spots_[1 - epochOf(frame)])
            if (spot.views >= enoughViews) look(inverse * spot.point, seen.camera, depth, spot);
        });
  }

  static void look(const cv::Point3d& point, const CameraIntrinsics& camera, const cv::Mat& depth,
                   Spot& spot) {
    if (point.z < nearest || point.z > farthest) return;
    const double u = camera.cx + camera.fx * point.x / point.z, v = camera.cy + camera.fy * point.y / point.z;
    if (!(u >= 0 && v >= 0 && u < depth.cols - 1 && v < depth.rows - 1)) return;
    const double seen = depth.at<float>(static_cast<int>(std::lround(v)), static_cast<int>(std::lround(u)));
    const double noise = noiseAt(point.z);
    if (!(seen > 0) || seen < point.z - noise) return;  // unknown, or something is in the way
    ++(seen > point.z + noise ? spot.empty : spot.full);
  }

  template <class Use>
  void forEachView(const Use& use) const {
    store_.forEachObservation([&](std::size_t frame, const Observation& seen) {
      const auto index = world_.places.findFrame(frame);
      if (index && world_.places.frames[*index].pose)
        use(frame, seen, depthOf(seen), rigidOf(*world_.places.frames[*index].pose));
      return true;
    });
  }

  static constexpr double nearest = 0.2, farthest = 5;  // [m]

  const WorldMap& world_;
  const WorldStore& store_;
  std::size_t firstNow_;
  std::array<Spots, 2> spots_;
};

/// Spots that are empty now, side by side.
struct Patch {
  std::vector<const Spot*> spots;
  int object = -1;  ///< the object of most of them
  bool isWhole = false;
  cv::Point3d middle, size;
};

void describe(Patch& patch, const std::map<int, std::size_t>& lookedAt) {
  std::map<int, std::size_t> objects;
  cv::Point3d low = patch.spots.front()->point, high = low, sum;
  for (const Spot* spot : patch.spots) {
    ++objects[spot->object];
    sum += spot->point;
    low = {std::min(low.x, spot->point.x), std::min(low.y, spot->point.y), std::min(low.z, spot->point.z)};
    high = {std::max(high.x, spot->point.x), std::max(high.y, spot->point.y),
            std::max(high.z, spot->point.z)};
  }
  patch.middle = sum * (1.0 / static_cast<double>(patch.spots.size()));
  patch.size = high - low + cv::Point3d(spotWidth, spotWidth, spotWidth);
  const auto most = std::ranges::max_element(objects, {}, [](const auto& entry) { return entry.second; });
  patch.object = most->first;
  patch.isWhole = patch.object >= 0 && static_cast<double>(most->second) >=
                                           wholeShare * static_cast<double>(lookedAt.at(patch.object));
}

/// In a fixed order.
std::vector<Patch> patchesOf(const Spots& spots) {
  std::map<VoxelKey, const Spot*> rest;
  std::map<int, std::size_t> lookedAt;
  for (const auto& [key, spot] : spots) {
    if (spot.isLookedAt()) ++lookedAt[spot.object];
    if (spot.isEmpty()) rest.emplace(key, &spot);
  }
  std::vector<Patch> patches;
  while (!rest.empty()) {
    Patch patch;
    std::vector<VoxelKey> reached{rest.begin()->first};
    patch.spots.push_back(rest.begin()->second);
    rest.erase(rest.begin());
    for (std::size_t i = 0; i < reached.size(); ++i)
      for (std::int32_t dx = -gap; dx <= gap; ++dx)
        for (std::int32_t dy = -gap; dy <= gap; ++dy)
          for (std::int32_t dz = -gap; dz <= gap; ++dz) {
            const auto next = rest.find({reached[i].x + dx, reached[i].y + dy, reached[i].z + dz});
            if (next == rest.end()) continue;
            reached.push_back(next->first);
            patch.spots.push_back(next->second);
            rest.erase(next);
          }
    if (patch.spots.size() < enoughSpots) continue;
    describe(patch, lookedAt);
    patches.push_back(std::move(patch));
  }
  return patches;
}

/// Words of each object relative to those of all objects: log probabilities less their means.
class ObjectWords {
 public:
  explicit ObjectWords(const WorldMap& world) {
    std::map<std::string, double> sums;
    double labeled = 0;
    for (const WorldObject& object : world.objects) {
      if (object.words.empty()) continue;
      ++labeled;
      for (const LabelProbability& word : object.words) sums[word.label] += logOf(word.probability);
    }
    for (const WorldObject& object : world.objects) {
      auto& own = words_[object.id];
      for (const LabelProbability& word : object.words)
        own[word.label] = logOf(word.probability) - sums[word.label] / labeled;
    }
  }

  /// The cosine; 0 where one has none.
  double alike(int a, int b) const {
    double both = 0, ofA = 0, ofB = 0;
    for (const auto& [label, value] : words_.at(a)) {
      ofA += value * value;
      if (const auto other = words_.at(b).find(label); other != words_.at(b).end())
        both += value * other->second;
    }
    for (const auto& [label, value] : words_.at(b)) ofB += value * value;
    return ofA > 0 && ofB > 0 ? both / std::sqrt(ofA * ofB) : 0;
  }

 private:
  static double logOf(double probability) { return std::log(std::max(probability, 1e-5)); }
  std::map<int, std::map<std::string, double>> words_;
};

bool haveOneSize(const cv::Point3d& a, const cv::Point3d& b) {
  std::array<double, 3> u{a.x, a.y, a.z}, v{b.x, b.y, b.z};
  std::ranges::sort(u);
  std::ranges::sort(v);
  constexpr double thin = 0.1;  // [m]: smaller lengths are not meaningful
  for (std::size_t i = 0; i < 3; ++i)
    if (std::max(u[i], v[i]) > sameSize * std::max({std::min(u[i], v[i]), thin})) return false;
  return true;
}

/// How surely two patches are of one thing, 0 … 2: one object that was pushed aside or turned, or alike ones.
double likeness(const ObjectWords& words, const Patch& gone, const Patch& now) {
  if (gone.object < 0 || now.object < 0) return 0;
  if (gone.object == now.object) return 2;
  const double alike = words.alike(gone.object, now.object);
  return alike >= enoughAlike && haveOneSize(gone.size, now.size) ? alike : 0;
}

ObjectChange changeOf(const Patch& patch, ObjectChange::Kind kind) {
  ObjectChange change;
  change.kind = kind;
  change.isWhole = patch.isWhole;
  change.area = spotWidth * spotWidth * static_cast<double>(patch.spots.size());
  const auto object = patch.object < 0 ? std::nullopt : std::optional(patch.object);
  if (kind == ObjectChange::Kind::gone) {
    change.before = object;
    change.from = patch.middle;
    change.lastBefore = (*std::ranges::max_element(patch.spots, {}, &Spot::last))->last;
  } else {
    change.now = object;
    change.to = patch.middle;
    change.firstNow = (*std::ranges::min_element(patch.spots, {}, &Spot::first))->first;
  }
  return change;
}

/// Objects gone since `firstNow` and new ones; pairs of these, most alike first, are moved objects.
std::vector<ObjectChange> changedObjects(const WorldMap& world, const WorldStore& store,
                                         std::size_t firstNow) {
  const Epochs epochs(world, store, world.places.frames.at(firstNow).number);
  const ObjectWords words(world);
  const std::vector<Patch> gone = patchesOf(epochs.spots(0)), now = patchesOf(epochs.spots(1));
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < gone.size(); ++i)
    for (std::size_t k = 0; k < now.size(); ++k)
      if (const double alike = likeness(words, gone[i], now[k]); alike > 0) pairs.emplace_back(-alike, i, k);
  std::ranges::sort(pairs);
  std::vector<bool> isJoined(now.size(), false);
  std::vector<ObjectChange> changes;
  for (const Patch& patch : gone) changes.push_back(changeOf(patch, ObjectChange::Kind::gone));
  for (const auto& [alike, i, k] : pairs) {
    ObjectChange& change = changes[i];
    if (change.kind == ObjectChange::Kind::moved || isJoined[k]) continue;
    const ObjectChange found = changeOf(now[k], ObjectChange::Kind::appeared);
    change.kind = ObjectChange::Kind::moved;
    change.now = found.now;
    change.to = found.to;
    change.firstNow = found.firstNow;
    isJoined[k] = true;
  }
  for (std::size_t k = 0; k < now.size(); ++k)
    if (!isJoined[k]) changes.push_back(changeOf(now[k], ObjectChange::Kind::appeared));
  for (ObjectChange& change : changes)
    for (std::size_t* frame : {&change.lastBefore, &change.firstNow}) *frame = world.places.indexOf(*frame);
  return changes;
}

/// The images of a place in one epoch.
struct EpochOfPlace {
  Moments words, embedded;
};

PlaceChange changeOf(int node, double distance, const Vocabulary& vocabulary, std::span<const float> before,
                     std::span<const float> now) {
  PlaceChange change{node, distance, {}};
  std::vector<float> differences;
  for (std::size_t i = 0; i < now.size(); ++i) differences.push_back(std::abs(now[i] - before[i]));
  for (const std::size_t label : bestLabels(DescriptorView(differences), 5))
    change.words.push_back({vocabulary[label], before[label], now[label]});
  return change;
}

/// Places whose mean images of the two epochs would be two places, most different first.
std::vector<PlaceChange> changedPlaces(const TopologicalMap& map, const MapStore& store,
                                       std::size_t firstNow) {
  const Mapper mapper = restoreMapper(store);
  const Mapper::Impl& scale = mapper.impl();
  const Moments nothing(map.vocabulary.size(), false);
  const EpochOfPlace none{nothing, nothing};
  std::map<int, std::array<EpochOfPlace, 2>> places;
  store.forEachDescriptor(0, [&](std::size_t frame, DescriptorView descriptor) {
    const std::size_t index = map.indexOf(frame);
    auto& epochs = places.try_emplace(map.frames.at(index).node, std::array{none, none}).first->second;
    EpochOfPlace& epoch = epochs[index >= firstNow ? 1 : 0];
    epoch.words.add(descriptor);
    epoch.embedded.add(scale.embeddedFrame(descriptor).embedded);
    return true;
  });
  std::vector<PlaceChange> changes;
  for (const auto& [node, epochs] : places) {
    const auto& [before, now] = epochs;
    if (std::min(before.words.weight(), now.words.weight()) < 5) continue;
    const double distance = compare(scale.distance.comparison, scale.bank.compared(before.embedded.mean()),
                                    scale.bank.compared(now.embedded.mean())) /
                            scale.thresholds.join;
    if (distance >= 1)
      changes.push_back(changeOf(node, distance, map.vocabulary, before.words.mean(), now.words.mean()));
  }
  std::ranges::sort(changes, std::ranges::greater{}, &PlaceChange::distance);
  return changes;
}

}  // namespace

std::string toString(ObjectChange::Kind kind) {
  constexpr const char* names[] = {"moved", "gone", "new"};
  return names[static_cast<int>(kind)];
}

Changes findChanges(const std::filesystem::path& path, std::optional<std::size_t> since) {
  MapStore map = MapStore::open(path, MapStore::Access::read);
  map.beginReading();
  const WorldStore store(map, MapStore::Access::read);
  WorldMap world{map.load()};
  store.read(world);
  KnownStore(map).read(world);
  const std::vector<Drive>& drives = world.places.drives;
  if (drives.size() < 2)
    fail(ErrorCode::insufficientData,
         "{} has only one drive; changes are told between drives: go on with "
         "another one by `estancia map --continue`",
         path.string());
  Changes changes{since.value_or(drives.size() - 1)};
  if (changes.since == 0 || changes.since >= drives.size())
    fail(ErrorCode::unknownName, "--since: the drives that others came before are 1 to {}, and {} is given",
         drives.size() - 1, changes.since);
  const std::size_t firstNow = drives[changes.since].firstFrame;
  changes.objects = changedObjects(world, store, firstNow);
  changes.places = changedPlaces(world.places, map, firstNow);
  changes.world = std::make_shared<const WorldMap>(std::move(world));
  return changes;
}

}  // namespace estancia
