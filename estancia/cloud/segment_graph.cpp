// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/segment_graph.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

namespace estancia {
namespace {

constexpr double kAcross = 6;  // [pixels]
constexpr float kFar = std::numeric_limits<float>::infinity();

enum class Side : std::uint8_t { contact, aInFront, bInFront, apart };

/// Two pixels of two segments.
struct PixelPair {
  std::uint32_t a, b;
  float distance;  ///< [m]
  float height;    ///< [m]
  Side side;
};

class Pairs {
 public:
  Pairs(const InverseDepth& grid, const Segmentation& segments, const cv::Vec3d& up)
      : grid_(grid), labels_(segments.labels), up_(up) {}

  /// Adjacent pixels.
  void touch(std::size_t i, std::size_t j) {
    if (labels_[i] == labels_[j] || !(grid_.raw[i] > 0) || !(grid_.raw[j] > 0)) return;
    if (labels_[i] > labels_[j]) std::swap(i, j);
    const float difference = grid_.raw[i] - grid_.raw[j];
    const bool same = std::abs(difference) < kDepthStep * std::min(grid_.raw[i], grid_.raw[j]);
    add(i, j, same ? Side::contact : difference > 0 ? Side::aInFront : Side::bInFront);
  }
  /// The next segment behind pixels without one.
  void skip(std::size_t i, std::ptrdiff_t step, int count) {
    if (labels_[i] == 0) return;
    for (int k = 1; k <= count; ++k) {
      auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + k * step);
      if (labels_[j] == 0) continue;
      if (k == 1 || labels_[i] == labels_[j]) return;
      if (labels_[i] > labels_[j]) std::swap(i, j);
      return add(i, j, Side::apart);
    }
  }
  std::vector<SegmentEdge> edges() {
    std::ranges::sort(pairs_, {}, [](const PixelPair& p) { return std::tuple(p.a, p.b, p.distance); });
    std::vector<SegmentEdge> result;
    for (std::size_t first = 0, last = 0; first < pairs_.size(); first = last) {
      while (last < pairs_.size() && pairs_[last].a == pairs_[first].a && pairs_[last].b == pairs_[first].b)
        ++last;
      result.push_back(edgeOf({&pairs_[first], last - first}));
    }
    return result;
  }

 private:
  void add(std::size_t i, std::size_t j, Side side) {
    const cv::Point3f p = grid_.point(i);
    const bool outside = labels_[i] == 0;
    pairs_.push_back({labels_[i], labels_[j],
                      outside ? kFar : static_cast<float>(cv::norm(grid_.point(j) - p)),
                      static_cast<float>(up_.dot({p.x, p.y, p.z})), side});
  }
  static SegmentEdge edgeOf(std::span<const PixelPair> pairs) {
    SegmentEdge edge{pairs.front().a, pairs.front().b};
    edge.gap = pairs[pairs.size() / 4].distance;
    for (const PixelPair& pair : pairs) {
      edge.aInFront += pair.side == Side::aInFront ? 1 : 0;
      edge.bInFront += pair.side == Side::bInFront ? 1 : 0;
      if (pair.side != Side::contact) continue;
      ++edge.contacts;
      edge.height += pair.height;
    }
    if (edge.contacts > 0) edge.height /= static_cast<double>(edge.contacts);
    return edge;
  }

  const InverseDepth& grid_;
  const std::vector<std::uint32_t>& labels_;
  cv::Vec3d up_;
  std::vector<PixelPair> pairs_;
};

}  // namespace

std::vector<SegmentEdge> segmentGraph(const InverseDepth& grid, const Segmentation& segments,
                                      const cv::Vec3d& up) {
  Pairs pairs(grid, segments, up);
  const int across = std::min(grid.pixels(kAcross), grid.margin);
  for (int v = 0; v < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      const std::size_t i = grid.at(u, v);
      pairs.touch(i, i + 1);
      pairs.touch(i, i + static_cast<std::size_t>(grid.stride));
      pairs.skip(i, 1, across);
      pairs.skip(i, grid.stride, across);
    }
  return pairs.edges();
}

}  // namespace estancia
