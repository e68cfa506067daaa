// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>
#include <vector>

#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

constexpr double distinct = 12;          // between two colors, in units of Lab
constexpr double compact = 3;            // distance of two colors, to the spread of each
constexpr double minPart = 100;          // [square pixels]
constexpr double minShare = 0.12;        // share of either side in both
constexpr double maxCommonShare = 0.55;  // share of a side's border that lies at the other, at most
constexpr double minSmoothShare = 0.7;   // share of the border at which the surface goes on
constexpr double sameFace = 0.95;        // cosine between normals to either side: 18°
constexpr double uprightPart = 0.5;      // sine of the rise from one side's center to the other's

constexpr float lightness = 0.25F;  // weight of lightness to chroma
constexpr float dark = 20;          // lightness below which chroma is noise

cv::Mat toLab(const cv::Mat& image) {
  cv::Mat lab;
  // OpenCV makes its tables at the first conversion, without a lock: two threads would both, and leak one's.
  static const bool tablesAreMade [[maybe_unused]] = [] {
    cv::Mat pixel;
    cv::cvtColor(cv::Mat3b(1, 1, cv::Vec3b()), pixel, cv::COLOR_BGR2Lab);
    return true;
  }();
  cv::cvtColor(image, lab, cv::COLOR_BGR2Lab);
  return lab;
}

/// Splits segments by color. Invariant: `boxes_` holds the bounding box of each segment of the constructor's
/// segmentation; split() only changes labels inside the box of its segment. Image, normals and colors outlive
/// it.
class Splitter {
 public:
  Splitter(const InverseDepth& grid, const HalfImage& half, const SegmentColors& colors, const cv::Vec3d& up,
           Segmentation& segments)
      : grid_(grid),
        half_(half),
        up_(up),
        features_(colors),
        segments_(segments),
        boxes_(segments.sizes.size()) {
    for (int v = 0; v < grid.camera.height; ++v)
      for (int u = 0; u < grid.camera.width; ++u)
        if (const std::uint32_t label = segments.labels[grid.at(u, v)]; label != 0)
          boxes_[label] |= cv::Rect(u, v, 1, 1);
  }

  void split(std::uint32_t segment) {
    if (segments_.sizes[segment] < 2 * grid_.area(minSegmentArea)) return;
    const cv::Rect box = boxes_[segment];
    cv::Mat_<int> parts = partsOf(segment, box);
    double most = 0;
    cv::minMaxLoc(parts, nullptr, &most);
    if (most < 2) return;
    const auto pairs = mergeParts(box, parts);
    if (pairs.empty()) return;
    joinApart(box, pairs, parts);
    std::vector<std::uint32_t> number(static_cast<std::size_t>(most) + 1);
    for (int v = 0; v < box.height; ++v)
      for (int u = 0; u < box.width; ++u) {
        if (parts(v, u) == 0) continue;
        std::uint32_t& to = number[static_cast<std::size_t>(parts(v, u))];
        if (to == 0) {  // the first part keeps the segment's number
          to = std::ranges::all_of(number, [](std::uint32_t n) { return n == 0; })
                   ? segment
                   : static_cast<std::uint32_t>(segments_.sizes.size());
          if (to != segment) segments_.sizes.push_back(0);
        }
        if (to == segment) continue;
        segments_.labels[grid_.at(box.x + u, box.y + v)] = to;
        ++segments_.sizes[to];
        --segments_.sizes[segment];
      }
  }

 private:
  /// Regions between edges of color, numbered from 1 on; 0 outside of the segment.
  cv::Mat_<int> partsOf(std::uint32_t segment, const cv::Rect& box) const {
    cv::Mat_<std::uint8_t> whole(box.size(), 0), smooth(box.size(), 0);
    const int reach = grid_.pixels(2);
    for (int v = 0; v < box.height; ++v)
      for (int u = 0; u < box.width; ++u) {
        if (segments_.labels[grid_.at(box.x + u, box.y + v)] != segment) continue;
        whole(v, u) = 255;
        smooth(v, u) = change(segment, box.x + u, box.y + v, reach, 0) < colorEdge &&
                               change(segment, box.x + u, box.y + v, 0, reach) < colorEdge
                           ? 255
                           : 0;
      }
    cv::Mat labels, boxes, centers;
    const int count = cv::connectedComponentsWithStats(smooth, labels, boxes, centers, 4, CV_32S);
    std::vector<int> number(static_cast<std::size_t>(count));
    int parts = 0;
    for (int i = 1; i < count; ++i)
      if (boxes.at<int>(i, cv::CC_STAT_AREA) >= grid_.area(minPart))
        number[static_cast<std::size_t>(i)] = ++parts;
    cv::Mat_<int> result(box.size(), 0);
    if (parts < 2) return result;
    // The other pixels join the nearest part.
    cv::Mat_<int> seeds(box.size()), nearest;
    std::transform(labels.begin<int>(), labels.end<int>(), seeds.begin(),
                   [&](int label) { return number[static_cast<std::size_t>(label)]; });
    cv::Mat distance;
    cv::distanceTransform(seeds == 0, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
    std::vector<int> of(seeds.total() + 1);
    for (int v = 0; v < box.height; ++v)
      for (int u = 0; u < box.width; ++u)
        if (seeds(v, u) != 0) of[static_cast<std::size_t>(nearest(v, u))] = seeds(v, u);
    for (int v = 0; v < box.height; ++v)
      for (int u = 0; u < box.width; ++u)
        if (whole(v, u) != 0) result(v, u) = of[static_cast<std::size_t>(nearest(v, u))];
    return result;
  }
  /// Change of color across a pixel; 0 at the rim of the segment.
  double change(std::uint32_t segment, int u, int v, int dx, int dy) const {
    if (segments_.labels[grid_.at(u - dx, v - dy)] != segment ||
        segments_.labels[grid_.at(u + dx, v + dy)] != segment)
      return 0;
    return cv::norm(features_(v + dy, u + dx) - features_(v - dy, u - dx));
  }
  using Pairs = std::set<std::pair<int, int>>;
  /// Joins adjacent parts until only things beside each other are left; returns which those are.
  Pairs mergeParts(const cv::Rect& box, cv::Mat_<int>& parts) const {
    for (;;) {
      bool changed = false;
      Pairs pairs;
      for (int v = 0; v + 1 < box.height; ++v)
        for (int u = 0; u + 1 < box.width; ++u)
          for (const int other : {parts(v, u + 1), parts(v + 1, u)})
            if (parts(v, u) != 0 && other != 0 && other != parts(v, u))
              pairs.insert(std::minmax(parts(v, u), other));
      for (const auto& [a, b] : pairs) {
        if (areBeside(box, parts == a, parts == b)) continue;
        parts.setTo(a, parts == b);
        changed = true;
        break;
      }
      if (!changed) return pairs;
    }
  }
  /// Joins parts that lie beside no other (behind an occluder) to that of the nearest color.
  void joinApart(const cv::Rect& box, const Pairs& pairs, cv::Mat_<int>& parts) const {
    double most = 0;
    cv::minMaxLoc(parts, nullptr, &most);
    std::vector<cv::Vec3d> colors(static_cast<std::size_t>(most) + 1);
    std::vector<double> counts(colors.size());
    for (int v = 0; v < box.height; ++v)
      for (int u = 0; u < box.width; ++u) {
        colors[static_cast<std::size_t>(parts(v, u))] += features_(box.y + v, box.x + u);
        ++counts[static_cast<std::size_t>(parts(v, u))];
      }
    for (std::size_t i = 1; i < colors.size(); ++i) colors[i] /= std::max(counts[i], 1.);
    std::set<int> beside;
    for (const auto& [a, b] : pairs) beside.insert({a, b});
    for (int i = 1; i <= static_cast<int>(most); ++i) {
      if (beside.contains(i) || counts[static_cast<std::size_t>(i)] == 0) continue;
      const int to = *std::ranges::min_element(beside, {}, [&](int k) {
        return cv::norm(colors[static_cast<std::size_t>(k)] - colors[static_cast<std::size_t>(i)]);
      });
      parts.setTo(to, parts == i);
    }
  }
  bool areBeside(const cv::Rect& box, const cv::Mat& a, const cv::Mat& b) const {
    double common = 0, silent = 0, told = 0;
    std::array<double, 2> borders{}, counts{};
    std::array<cv::Vec3d, 2> sums{}, colors{};
    std::array<double, 2> squares{};
    const auto of = [&](int u, int v) {
      if (u < 0 || v < 0 || u >= box.width || v >= box.height) return 0;
      return a.at<std::uint8_t>(v, u) != 0 ? 1 : b.at<std::uint8_t>(v, u) != 0 ? 2 : 0;
    };
    for (int v = 0; v < box.height; ++v)
      for (int u = 0; u < box.width; ++u) {
        const int side = of(u, v);
        if (side == 0) continue;
        const auto k = static_cast<std::size_t>(side - 1);
        const cv::Point3f p = grid_.point(box.x + u, box.y + v);
        sums[k] += cv::Vec3d(p.x, p.y, p.z);
        ++counts[k];
        const cv::Vec3d color = features_(box.y + v, box.x + u);
        colors[k] += color;
        squares[k] += color.dot(color);
        constexpr int around[][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
        for (const auto& [dx, dy] : around) {
          const int other = of(u + dx, v + dy);
          borders[k] += other != side ? 1 : 0;
          if (side != 1 || other != 2) continue;
          ++common;
          const int same = faces(box.x + u, box.y + v, dx, dy);
          told += same >= 0 ? 1 : 0;
          silent += same > 0 && differ(box.x + u, box.y + v, dx, dy) ? 1 : 0;
        }
      }
    const double least = std::max(minShare * (counts[0] + counts[1]), grid_.area(minSegmentArea));
    if (std::min(counts[0], counts[1]) < least) return false;
    double spread = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      colors[k] /= counts[k];
      spread = std::max(spread, std::sqrt(std::max(0., squares[k] / counts[k] - colors[k].dot(colors[k]))));
    }
    if (cv::norm(colors[0] - colors[1]) < compact * spread) return false;
    const cv::Vec3d between = sums[1] / counts[1] - sums[0] / counts[0];
    return common > 0 && common < maxCommonShare * std::min(borders[0], borders[1]) && told > 0.5 * common &&
           silent > minSmoothShare * told && std::abs(between.dot(up_)) < uprightPart * cv::norm(between);
  }
  /// A pixel some steps away, inside of the image.
  cv::Point away(int u, int v, int dx, int dy, int steps) const {
    return {std::clamp(u + steps * dx, 0, grid_.camera.width - 1),
            std::clamp(v + steps * dy, 0, grid_.camera.height - 1)};
  }
  /// Whether the surface goes on across a border: 1, 0, or -1 where that is unknown.
  int faces(int u, int v, int dx, int dy) const {
    const int steps = grid_.pixels(5);
    const cv::Point a = away(u, v, dx, dy, -steps), b = away(u, v, dx, dy, steps + 1);
    const cv::Vec3d one = half_.normal(a.x, a.y), other = half_.normal(b.x, b.y);
    if (one == cv::Vec3d() || other == cv::Vec3d()) return -1;
    return one.dot(other) > sameFace ? 1 : 0;
  }
  bool differ(int u, int v, int dx, int dy) const {
    const int steps = grid_.pixels(5);
    return cv::norm(features_(away(u, v, dx, dy, -steps)) - features_(away(u, v, dx, dy, steps + 1))) >
           distinct;
  }

  const InverseDepth& grid_;
  const HalfImage& half_;
  cv::Vec3d up_;
  const SegmentColors& features_;
  Segmentation& segments_;
  std::vector<cv::Rect> boxes_;
};

}  // namespace

SegmentColors segmentColors(const cv::Mat& image, const cv::Size& size) {
  if (image.empty()) return {};
  cv::Mat fitting = image, blurred;
  if (image.size() != size) cv::resize(image, fitting, size, 0, 0, cv::INTER_AREA);
  cv::blur(fitting, blurred, {3, 3});
  const cv::Mat lab = toLab(blurred);
  SegmentColors features(size);
  std::transform(lab.begin<cv::Vec3b>(), lab.end<cv::Vec3b>(), features.begin(), [](const cv::Vec3b& c) {
    const float l = static_cast<float>(c[0]) / 2.55F, scale = 66 / std::max(l + 16, dark + 16);
    return cv::Vec3f(lightness * l, scale * (static_cast<float>(c[1]) - 128),
                     scale * (static_cast<float>(c[2]) - 128));
  });
  return features;
}

void splitByColor(const InverseDepth& grid, const HalfImage& half, const SegmentColors& colors,
                  const cv::Vec3d& up, Segmentation& segments) {
  Splitter splitter(grid, half, colors, up, segments);
  for (std::uint32_t i = 1, count = static_cast<std::uint32_t>(segments.sizes.size()); i < count; ++i)
    splitter.split(i);
}

}  // namespace estancia
