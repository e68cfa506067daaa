// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/localization_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

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

struct Step {
  int images;
  float chance;
};
constexpr std::array<Step, 3> drivingOn{{{0, 0.2F}, {1, 0.6F}, {2, 0.2F}}};
constexpr std::array<Step, 3> drivingBack{{{0, 0.2F}, {-1, 0.6F}, {-2, 0.2F}}};
constexpr std::array<Step, 3> standing{{{-1, 0.05F}, {0, 0.9F}, {1, 0.05F}}};
constexpr std::array<const std::array<Step, 3>*, 3> ways{&drivingOn, &drivingBack, &standing};

/// The image `by` steps on, or `images` when that leaves the mapped drive.
std::size_t moved(std::size_t image, int by, std::size_t images) {
  const auto to = static_cast<std::ptrdiff_t>(image) + by;
  return to < 0 ? images : std::min(static_cast<std::size_t>(to), images);
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

PlaceFilter::PlaceFilter(std::vector<std::size_t> nodeOfImage, std::size_t nodes,
                         const std::vector<std::pair<std::size_t, std::size_t>>& edges,
                         PlaceFilterOptions options)
    : nodeOf_(std::move(nodeOfImage)), imagesOf_(nodes), linked_(nodes), options_(options) {
  for (std::size_t image = 0; image < nodeOf_.size(); ++image) imagesOf_[nodeOf_[image]].push_back(image);
  for (const auto& [a, b] : edges) {
    if (a == b || imagesOf_[a].empty() || imagesOf_[b].empty()) continue;
    linked_[a].push_back(b);
    linked_[b].push_back(a);
  }
  for (auto& others : linked_) {
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
  }
}

std::size_t PlaceFilter::states() const {
  return ways.size() * images();
}

void PlaceFilter::predict(std::span<const float> in, const PlanarMotion&, std::span<float> out) const {
  const std::size_t n = images();
  const auto turn = static_cast<float>(options_.turnAround);
  const auto drive = static_cast<float>(1 - options_.alongEdges - options_.anywhere);
  double anywhere =
      0;  // mass that may be at any image: by chance, or because it drove out of the mapped drive
  std::vector<float> nodeMass(imagesOf_.size(), 0.0F);
  float outside = 0;
  std::fill(out.begin(), out.end(), 0.0F);
  for (std::size_t i = 0; i < n; ++i) {
    float here = 0;
    for (std::size_t way = 0; way < ways.size(); ++way) here += in[way * n + i];
    anywhere += options_.anywhere * here;
    nodeMass[nodeOf_[i]] += here;
    for (std::size_t way = 0; way < ways.size(); ++way) {
      const float kept =
          drive * ((1 - turn) * in[way * n + i] + turn * here / static_cast<float>(ways.size()));
      for (const Step& step : *ways[way]) {
        const std::size_t to = moved(i, step.images, n);
        (to < n ? out[way * n + to] : outside) += kept * step.chance;
      }
    }
  }
  // Mass along an edge spreads evenly over the linked nodes' images; without edges it may be anywhere.
  const auto along = static_cast<float>(options_.alongEdges);
  anywhere += outside;
  std::vector<float> inflow(imagesOf_.size(), 0.0F);
  for (std::size_t node = 0; node < linked_.size(); ++node) {
    if (linked_[node].empty()) {
      anywhere += static_cast<double>(along) * nodeMass[node];
      continue;
    }
    const float share = along * nodeMass[node] / static_cast<float>(linked_[node].size());
    for (const std::size_t other : linked_[node]) inflow[other] += share;
  }
  const auto everywhere = static_cast<float>(anywhere / static_cast<double>(states()));
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t node = nodeOf_[i];
    const float more = everywhere + inflow[node] / static_cast<float>(ways.size() * imagesOf_[node].size());
    for (std::size_t way = 0; way < ways.size(); ++way) out[way * n + i] += more;
  }
}

void PlaceFilter::backward(std::span<const float> in, const PlanarMotion&, std::span<float> out) const {
  const std::size_t n = images();
  const auto turn = static_cast<float>(options_.turnAround);
  const auto drive = static_cast<float>(1 - options_.alongEdges - options_.anywhere);
  const auto along = static_cast<float>(options_.alongEdges);
  std::vector<double> nodeMean(imagesOf_.size(), 0.0);
  double total = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t way = 0; way < ways.size(); ++way) {
      nodeMean[nodeOf_[i]] += in[way * n + i];
      total += in[way * n + i];
    }
  const double mean = total / static_cast<double>(states());
  for (std::size_t node = 0; node < nodeMean.size(); ++node)
    if (!imagesOf_[node].empty()) nodeMean[node] /= static_cast<double>(ways.size() * imagesOf_[node].size());
  for (std::size_t i = 0; i < n; ++i) {
    const auto& linked = linked_[nodeOf_[i]];
    double ahead = linked.empty() ? mean : 0;
    for (const std::size_t other : linked) ahead += nodeMean[other] / static_cast<double>(linked.size());
    std::array<float, ways.size()> driven{};
    float allWays = 0;
    for (std::size_t way = 0; way < ways.size(); ++way) {
      for (const Step& step : *ways[way]) {
        const std::size_t to = moved(i, step.images, n);
        driven[way] += step.chance * (to < n ? in[way * n + to] : static_cast<float>(mean));
      }
      allWays += driven[way] / static_cast<float>(ways.size());
    }
    const auto jumps = static_cast<float>(along * ahead + options_.anywhere * mean);
    for (std::size_t way = 0; way < ways.size(); ++way)
      out[way * n + i] = drive * ((1 - turn) * driven[way] + turn * allWays) + jumps;
  }
}

std::vector<float> PlaceFilter::likelihood(std::span<const float> distances) const {
  const double n = static_cast<double>(distances.size());
  const double mean = std::accumulate(distances.begin(), distances.end(), 0.0) / n;
  double variance = 0;
  for (const float d : distances) variance += (d - mean) * (d - mean) / n;
  const float smallest = *std::min_element(distances.begin(), distances.end());
  const double scale = variance > 0 ? options_.temper / std::sqrt(variance) : 0;
  std::vector<float> result(distances.size());
  for (std::size_t i = 0; i < distances.size(); ++i)
    result[i] = static_cast<float>(std::exp(scale * (smallest - distances[i])));
  return result;
}

void PlaceFilter::observe(std::span<const float> likelihood, std::span<float> state) const {
  const std::size_t n = images();
  double total = 0;
  for (std::size_t s = 0; s < state.size(); ++s) {
    state[s] *= likelihood[s % n];
    total += state[s];
  }
  const auto scale = static_cast<float>(1 / total);  // never 0: `anywhere` keeps every state alive
  for (float& p : state) p *= scale;
}

Belief PlaceFilter::belief(std::span<const float> state, std::span<const float>) const {
  const std::size_t n = images();
  Belief belief{std::vector<double>(n, 0.0), {}};
  for (std::size_t s = 0; s < state.size(); ++s) belief.images[s % n] += state[s];
  belief.nearest = belief.images;
  return belief;
}

}  // namespace estancia
