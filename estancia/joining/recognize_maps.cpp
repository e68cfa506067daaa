// SPDX-License-Identifier: Apache-2.0
#include "estancia/joining/merge_plan.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/session/drive_alignment.hpp"
#include "estancia/session/drive_guide.hpp"
#include "estancia/session/session_impl.hpp"
#include "estancia/world/register_drive.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t maxInBlock = 10;   // maps that are compared with as many others at once
constexpr std::size_t maxFrames = 4096;  // frames of a map in which, or of drives that, are localized
constexpr std::size_t lookahead = 20;    // frames
constexpr std::size_t minVotes = 3;      // images that agree on a place
constexpr std::size_t minSeen = 5;       // depth images without which depth cannot confirm

/// Few maps in small blocks, so that all cores have some.
std::size_t blockSizeOf(std::size_t maps) {
  return std::clamp<std::size_t>(maps / 6, 1, maxInBlock);
}

/// Data of a map that comparison needs.
struct Compared {
  Mapper mapper;
  std::size_t frames;
};

std::vector<Compared> comparedMaps(std::span<const fs::path> maps) {
  std::vector<Compared> compared;
  for (const fs::path& path : maps) {
    MapStore store = MapStore::open(path, MapStore::Access::read);
    store.beginReading();
    Compared& map = compared.emplace_back(Compared{restoreMapper(store), store.frameCount()});
    map.mapper.impl().endModes();
    map.mapper.impl().views.clear();  // only means are compared
  }
  return compared;
}

std::span<const fs::path> block(std::span<const fs::path> maps, std::size_t number) {
  const std::size_t size = blockSizeOf(maps.size()), begin = number * size;
  return maps.subspan(begin, std::min(size, maps.size() - begin));
}

/// The links between the maps of two blocks, and how many frames these maps had, as text.
std::string linksOfBlocks(std::span<const fs::path> maps, std::size_t row, std::size_t column) {
  std::vector<Compared> first = comparedMaps(block(maps, row));
  std::vector<Compared> others = row == column ? std::vector<Compared>() : comparedMaps(block(maps, column));
  std::vector<Compared>& second = row == column ? first : others;
  const std::size_t size = blockSizeOf(maps.size());
  auto links = nlohmann::json::array(), frames = nlohmann::json::array();
  for (std::size_t i = 0; i < first.size(); ++i) {
    frames.push_back({row * size + i, first[i].frames});
    for (std::size_t j = row == column ? i + 1 : 0; j < second.size(); ++j) {
      if (interrupted()) throw Interrupted("stopped; nothing was changed");
      const PlaceLinker linker(first[i].mapper.impl(), second[j].mapper.impl());
      for (const PlaceLink& link : linker.nearest())
        links.push_back(
            {row * size + i, column * size + j, link.a, link.b, link.distance, link.threshold, link.isSure});
    }
  }
  for (std::size_t j = 0; j < others.size(); ++j) frames.push_back({column * size + j, others[j].frames});
  return nlohmann::json{{"links", links}, {"frames", frames}}.dump();
}

/// T_a_b, where depth confirms it or cannot, and words are enough.
std::optional<cv::Affine3d> confirmed(const DriveAlignment::Estimate& estimate, const MapSource& a,
                                      const MapSource& b) {
  std::vector<ObservationPose> seenByA, seenByB;
  const auto collect = [](const MapSource& source, std::size_t offset, std::vector<ObservationPose>& seen) {
    for (std::size_t i = 0; i < source.map.frames.size(); ++i)
      if (source.isObserved[i] && source.map.frames[i].pose)
        seen.push_back({offset + i, rigidOf(*source.map.frames[i].pose)});
  };
  const std::size_t framesOfA = a.map.frames.size();
  collect(a, 0, seenByA);
  collect(b, framesOfA, seenByB);
  if (std::min(seenByA.size(), seenByB.size()) < minSeen)
    return estimate.isCertain() ? std::optional(estimate.transform) : std::nullopt;
  const auto observation = [&](std::size_t frame) {
    return frame < framesOfA ? *a.observation(frame) : *b.observation(frame - framesOfA);
  };
  return registerDrive(seenByB, seenByA, observation, estimate.transform);
}

/// The drives of a map as they are localized in another one.
class MapLocalization {
 public:
  MapLocalization(const MapSource& a, const MapSource& b, const LocalizerMap& known)
      : a_(a), b_(b), known_(known), alignment_(nearOf(a).nearDistance, nearOf(a).nearAngle) {}

  void take(std::size_t frame, const Localization& found) {
    auto& [images, votes] = places_[b_.map.frames[frame].node];
    ++images;
    if (!isCertain(found)) return;
    ++votes[found.beliefNode];
    const auto& own = b_.map.frames[frame].pose;
    const auto& view = known_.map.frames.at(found.beliefImage).pose;
    if (own && view && showsView(found)) alignment_.add(*own, *view);
  }

  LocalizedMap result() const {
    LocalizedMap found;
    Mapper a = restoreMapper(a_.store), b = restoreMapper(b_.store);
    for (Mapper* mapper : {&a, &b}) mapper->impl().endModes();
    const PlaceLinker linker(a.impl(), b.impl());
    for (const auto& [place, seen] : places_) {
      const auto& [images, votes] = seen;
      const auto most = std::ranges::max_element(votes, {}, [](const auto& vote) { return vote.second; });
      if (most == votes.end() || most->second < minVotes || 2 * most->second <= images) continue;
      if (const auto link = linker.between(most->first, place)) found.links.push_back(*link);
    }
    if (const auto estimate = alignment_.estimate()) found.alignment = confirmed(*estimate, a_, b_);
    return found;
  }

 private:
  static MapperOptions nearOf(const MapSource& source) {
    return settingsFromJson(source.store.identity().settings);
  }

  const MapSource &a_, &b_;
  const LocalizerMap& known_;
  DriveAlignment alignment_;
  /// For each place of b: number of images, and how many were taken in each place of a.
  std::map<int, std::pair<std::size_t, std::map<int, std::size_t>>> places_;
};

}  // namespace

std::size_t LinkedMaps::sure() const {
  return static_cast<std::size_t>(std::ranges::count_if(links, &PlaceLink::isSure));
}

std::vector<LinkedMaps> linkMaps(std::span<const fs::path> maps, const ShareWork& share,
                                 const std::function<std::size_t(std::size_t)>& framesOf) {
  const std::size_t size = blockSizeOf(maps.size()), blocks = (maps.size() + size - 1) / size;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t row = 0; row < blocks; ++row)
    for (std::size_t column = row; column < blocks; ++column) pairs.emplace_back(row, column);
  const std::vector<std::string> results = share.run(pairs.size(), [&](std::size_t piece) {
    return linksOfBlocks(maps, pairs[piece].first, pairs[piece].second);
  });
  std::map<std::pair<std::size_t, std::size_t>, std::vector<PlaceLink>> found;
  for (const std::string& text : results) {
    const auto result = nlohmann::json::parse(text);
    for (const auto& map : result.at("frames"))
      if (const std::size_t number = map.at(0); map.at(1) != framesOf(number))
        fail(ErrorCode::busy, "{} is being written; merge it when that has ended", maps[number].string());
    for (const auto& link : result.at("links"))
      found[{link.at(0), link.at(1)}].push_back({link.at(2), link.at(3), link.at(4), link.at(5), link.at(6)});
  }
  std::vector<LinkedMaps> linked;
  for (auto& [ends, links] : found) linked.push_back({ends.first, ends.second, std::move(links)});
  return linked;
}

LocalizedMap localizeMap(const fs::path& first, const fs::path& second) {
  const MapSource a(first), b(second);
  const auto known = std::make_shared<const LocalizerMap>(readLocalizerMap(a.store, maxFrames));
  LocalizerOptions options;
  options.lookahead = lookahead;
  MapLocalization localization(a, b, *known);
  const std::size_t stride = (b.map.frames.size() + maxFrames - 1) / maxFrames;
  for (std::size_t drive = 0; drive < b.map.drives.size(); ++drive) {
    Localizer localizer(known, options);
    std::size_t answered = b.map.drives[drive].firstFrame;
    const auto take = [&](const std::vector<Localization>& answers) {
      for (const Localization& answer : answers) {
        localization.take(answered, answer);
        answered += stride;
      }
    };
    for (std::size_t frame = answered; frame < b.end(drive); frame += stride) {
      if (interrupted()) throw Interrupted("stopped; nothing was changed");
      const auto given = b.givenPose(frame);
      take(localizer.add(b.descriptor(frame), given ? given : b.map.frames[frame].pose));
    }
    take(localizer.finish());
  }
  return localization.result();
}

}  // namespace estancia
