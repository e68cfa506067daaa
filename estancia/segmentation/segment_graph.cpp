// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/segmentation_stages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

namespace estancia {
namespace {

constexpr double searchWidth = 6;  // [pixels]
constexpr double colorReach = 2;   // from a contact to either side [pixels]
constexpr float far = std::numeric_limits<float>::infinity();

enum class Side : std::uint8_t { contact, aInFront, bInFront, apart };

/// Two pixels of two segments.
struct PixelPair {
  std::uint32_t a, b;
  float distance;  ///< [m]
  float height;    ///< [m]
  float contrast;
  Side side;
};

/// Collects pairs of adjacent pixels of different segments. Life cycle: touch() and skip() for all pixels,
/// then edges() once. Invariant: in each pair the segment with the lower number is `a`.
class Pairs {
 public:
  Pairs(const InverseDepth& grid, const Segmentation& segments, const cv::Vec3d& up,
        const SegmentColors& colors)
      : grid_(grid), labels_(segments.labels), up_(up), colors_(colors), reach_(grid.pixels(colorReach)) {}

  /// A pixel and the next one in its row or column.
  void touch(cv::Point at, cv::Point step) {
    std::size_t i = grid_.at(at.x, at.y), j = grid_.at(at.x + step.x, at.y + step.y);
    if (labels_[i] == labels_[j] || !(grid_.raw[i] > 0) || !(grid_.raw[j] > 0)) return;
    const float difference = grid_.raw[i] - grid_.raw[j];
    const bool same = std::abs(difference) < depthStep * std::min(grid_.raw[i], grid_.raw[j]);
    const bool ascending = labels_[i] < labels_[j];
    const Side side = same ? Side::contact : (difference > 0) == ascending ? Side::aInFront : Side::bInFront;
    const float contrast =
        same && !colors_.empty() && labels_[i] != 0 && labels_[j] != 0
            ? static_cast<float>(cv::norm(colors_(inside(at, -step)) - colors_(inside(at + step, step))))
            : 0;
    if (!ascending) std::swap(i, j);
    add(i, j, side, contrast);
  }
  /// The next segment behind pixels without one.
  void skip(std::size_t i, std::ptrdiff_t step, int count) {
    if (labels_[i] == 0) return;
    for (int k = 1; k <= count; ++k) {
      auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + k * step);
      if (labels_[j] == 0) continue;
      if (k == 1 || labels_[i] == labels_[j]) return;
      if (labels_[i] > labels_[j]) std::swap(i, j);
      return add(i, j, Side::apart, 0);
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
  /// The pixel of the same segment, a little farther from its border.
  cv::Point inside(cv::Point at, cv::Point step) const {
    const std::uint32_t label = labels_[grid_.at(at.x, at.y)];
    const cv::Rect image(0, 0, grid_.camera.width, grid_.camera.height);
    for (int k = 0; k < reach_; ++k) {
      const cv::Point next = at + step;
      if (!image.contains(next) || labels_[grid_.at(next.x, next.y)] != label) break;
      at = next;
    }
    return at;
  }
  void add(std::size_t i, std::size_t j, Side side, float contrast) {
    const cv::Point3f p = grid_.point(i);
    const bool outside = labels_[i] == 0;
    pairs_.push_back({labels_[i], labels_[j],
                      outside ? far : static_cast<float>(cv::norm(grid_.point(j) - p)),
                      static_cast<float>(up_.dot({p.x, p.y, p.z})), contrast, side});
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
      edge.contrast += pair.contrast;
    }
    if (edge.contacts > 0) {
      edge.height /= static_cast<double>(edge.contacts);
      edge.contrast /= static_cast<double>(edge.contacts);
    }
    return edge;
  }

  const InverseDepth& grid_;
  const std::vector<std::uint32_t>& labels_;
  cv::Vec3d up_;
  const SegmentColors& colors_;
  int reach_;
  std::vector<PixelPair> pairs_;
};

}  // namespace

std::vector<SegmentEdge> segmentGraph(const InverseDepth& grid, const Segmentation& segments,
                                      const cv::Vec3d& up, const SegmentColors& colors) {
  Pairs pairs(grid, segments, up, colors);
  const int across = std::min(grid.pixels(searchWidth), grid.margin);
  for (int v = 0; v < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      const std::size_t i = grid.at(u, v);
      pairs.touch({u, v}, {1, 0});
      pairs.touch({u, v}, {0, 1});
      pairs.skip(i, 1, across);
      pairs.skip(i, grid.stride, across);
    }
  return pairs.edges();
}

}  // namespace estancia
