// SPDX-License-Identifier: Apache-2.0
#include "estancia/joining/map_source.hpp"

#include <algorithm>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {
namespace {

TopologicalMap asOfNow(MapStore& store) {
  store.beginReading();
  return store.load();
}

}  // namespace

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
