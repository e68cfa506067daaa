// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/localization_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "estancia/localization/place_filter.hpp"
#include "estancia/localization/pose_filter.hpp"
#include "estancia/map_file/places.hpp"

namespace estancia {
namespace {

std::vector<std::optional<PlanarPose>> posesOf(const LocalizerMap& source) {
  std::vector<Pose> poses;
  for (const MappedFrame& frame : source.map.frames)
    if (frame.pose) poses.push_back(*frame.pose);
  const Floor floor(poses);
  std::vector<std::optional<PlanarPose>> images(source.images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const MappedFrame& frame = source.map.frames.at(i * source.stride);
    if (frame.pose) images[i] = floor.project(*frame.pose);
  }
  return images;
}

/// From pairs of at most 500 images, evenly taken, with all the others.
std::optional<NearEvidence> evidenceOf(const std::vector<std::optional<PlanarPose>>& images,
                                       const std::function<float(std::size_t, std::size_t)>& distance,
                                       const PlaceFilterOptions& options) {
  constexpr std::size_t maxImages = 500, fewest = 30;
  constexpr std::size_t neighbors = 3;  // in the drive: nearly the same image, more alike than on a return
  const std::size_t stride = (images.size() + maxImages - 1) / maxImages;
  std::vector<float> near, far, adjacent;
  for (std::size_t i = 0; i < images.size(); i += stride)
    for (std::size_t j = 0; j < images.size(); ++j) {
      const auto &a = images[i], &b = images[j];
      if (i == j || !a || !b) continue;
      const bool isNear =
          std::hypot(a->x - b->x, a->y - b->y) <= options.nearDistance &&
          std::abs(wrapped(a->heading - b->heading)) <= options.nearAngle * std::numbers::pi / 180;
      if (!isNear && j % stride != 0) continue;
      const std::size_t apart = i < j ? j - i : i - j;
      (!isNear ? far : apart < neighbors ? adjacent : near).push_back(distance(i, j));
    }
  if (near.size() < fewest) near.insert(near.end(), adjacent.begin(), adjacent.end());
  if (near.size() < fewest || far.size() < fewest) return std::nullopt;
  return NearEvidence(near, far);
}

std::unique_ptr<const LocalizationFilter> placeFilter(const LocalizerMap& source,
                                                      const PlaceFilterOptions& options) {
  const TopologicalMap& map = source.map;
  std::vector<std::size_t> nodeOfImage;
  for (std::size_t i = 0; i < source.images.size(); ++i)
    nodeOfImage.push_back(indexOf(map, map.frames.at(i * source.stride).node));
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  for (const Transition& transition : map.transitions)
    edges.emplace_back(indexOf(map, transition.from), indexOf(map, transition.to));
  return std::make_unique<PlaceFilter>(std::move(nodeOfImage), map.nodes.size(), edges, options);
}

}  // namespace

std::unique_ptr<const LocalizationFilter> makeFilter(
    const LocalizerMap& source, const std::function<float(std::size_t, std::size_t)>& distance,
    const PlaceFilterOptions& options) {
  std::vector<std::optional<PlanarPose>> images = posesOf(source);
  const auto posed = static_cast<std::size_t>(
      std::ranges::count_if(images, [](const auto& image) { return image.has_value(); }));
  if (2 * posed >= images.size())
    if (auto evidence = evidenceOf(images, distance, options))
      return std::make_unique<PoseFilter>(std::move(images), std::move(*evidence), options);
  return placeFilter(source, options);
}

}  // namespace estancia
