// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

constexpr std::size_t shapePoints = 400;  // points of a segment
constexpr std::size_t enoughPoints = 5;   // minimum for a decision
constexpr float facesUp = 0.8F;           // cosine between a level surface's normal and up: 37°
constexpr double bodySize = 0.5;          // what one does not carry in a hand is larger [m]
// tolerance of heights: [m], and its growth with depth [m at 1 m]
constexpr double heightBand = 0.03, heightNoise = 0.005;
constexpr double footHeight = 0.05;     // height of the lower part of a low thing [m]
constexpr double minInside = 0.015;     // distance to the border of a surface that carries things [m]
constexpr double widthRatio = 0.6;      // width of a thing, to what it stands on, and of a stem, to its crown
constexpr double stemWidthRatio = 0.8;  // … to a crown of leaves
constexpr double leaves = 0.7;          // share of points with a normal, below which a segment is no surface
constexpr float nextTo = 0.1F;          // between parts of a piece of furniture [m]
constexpr float crumbGap = 0.05F;       // between leaves [m]
constexpr double loose = 0.3;           // size of a loose part, to what it belongs to
constexpr double maxBelow = 0.5;        // what carries a table begins so far below its top [m]

/// A sample of a segment, in level coordinates: x and y, then height.
struct SegmentShape {
  std::vector<cv::Vec3d> points;
  std::vector<std::uint8_t> level;  ///< one value a point: its surface faces up
  std::size_t smooth = 0;           ///< points with a normal
  double low = 0, high = 0;         ///< range of all but 2 % of the points [m]
  double wide = 0;                  ///< the diagonal of its extent in x and y [m]
  bool known() const { return points.size() >= enoughPoints; }
  bool isLeaves() const { return static_cast<double>(smooth) < leaves * static_cast<double>(points.size()); }
  bool isBody() const { return std::max(wide / 1.2, high - low) > bodySize; }
};

void measureShape(SegmentShape& shape) {
  if (shape.points.empty()) return;
  std::vector<double> along[3];
  for (const cv::Vec3d& p : shape.points)
    for (int k = 0; k < 3; ++k) along[k].push_back(p[k]);
  for (auto& values : along) std::ranges::sort(values);
  const std::size_t first = shape.points.size() / 50, last = shape.points.size() - 1 - first;
  shape.low = along[2][first];
  shape.high = along[2][last];
  shape.wide = std::hypot(along[0][last] - along[0][first], along[1][last] - along[1][first]);
}

std::vector<SegmentShape> shapesOf(const InverseDepth& grid, const HalfImage& half, const cv::Vec3d& up,
                                   const Segmentation& segments) {
  const cv::Vec3d x = cv::normalize(std::abs(up[0]) < 0.9 ? up.cross(cv::Vec3d(1, 0, 0))
                                                          : up.cross(cv::Vec3d(0, 1, 0))),
                  y = up.cross(x);
  std::vector<SegmentShape> shapes(segments.sizes.size());
  std::vector<std::size_t> skip(segments.sizes.size());
  for (int v = 0; v < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      const std::uint32_t label = segments.labels[grid.at(u, v)];
      if (label == 0 || skip[label]-- != 0) continue;
      skip[label] = segments.sizes[label] / shapePoints;
      const cv::Point3f point = grid.point(u, v);
      const cv::Vec3d p(point.x, point.y, point.z);
      const double faces = -half.normal(u, v).dot(up);
      shapes[label].points.emplace_back(p.dot(x), p.dot(y), p.dot(up));
      shapes[label].level.push_back(faces > facesUp);
      shapes[label].smooth += faces != 0 ? 1 : 0;
    }
  for (SegmentShape& shape : shapes) measureShape(shape);
  return shapes;
}

cv::Point2f foot(const cv::Vec3d& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1])};
}

/// The convex hull, from above, of what faces up between two heights; empty when that is little.
std::vector<cv::Point2f> levelHull(const SegmentShape& shape, double low, double high) {
  std::vector<cv::Point2f> level, hull;
  for (std::size_t i = 0; i < shape.points.size(); ++i)
    if (shape.level[i] != 0 && shape.points[i][2] > low && shape.points[i][2] < high)
      level.push_back(foot(shape.points[i]));
  if (level.size() >= enoughPoints) cv::convexHull(level, hull);
  return hull;
}

/// The share of the points below `top` that lie at least `margin` within the hull.
double shareWithin(const SegmentShape& shape, const std::vector<cv::Point2f>& hull, double margin,
                   double top = HUGE_VAL) {
  double inside = 0, all = 0;
  for (const cv::Vec3d& p : shape.points) {
    if (p[2] > top) continue;
    ++all;
    inside += cv::pointPolygonTest(hull, foot(p), true) > margin ? 1 : 0;
  }
  return all > 0 ? inside / all : 0;
}

/// Whether a segment begins where a body ends.
bool isOnTop(const SegmentShape& part, const SegmentShape& body, double band) {
  return part.known() && body.known() && body.isBody() && part.low > body.high - band;
}

/// Whether a segment is a thing that stands on another: it begins where they touch, and stands above all of
/// a wider one, or within the border of the other's level surface.
bool standsOn(const SegmentShape& thing, const SegmentShape& base, double height, double band) {
  if (!thing.known() || !base.known() || thing.low < height - band) return false;
  const double smaller = base.high - base.low > bodySize ? 1 : widthRatio;  // a cabinet is no seat
  if (thing.low > base.high - band && thing.wide < smaller * base.wide) return true;
  const auto hull = levelHull(base, height - heightBand - band, height + heightBand + band);
  const double foot = thing.low + std::max(footHeight, 0.3 * (thing.high - thing.low));
  return !hull.empty() && shareWithin(thing, hull, minInside, foot) > 0.5;
}

/// How the lower ends of a segment's columns end.
struct LowerEnds {
  std::size_t open = 0;  ///< before what is farther
  std::size_t all = 0;
  bool areFree() const { return 10 * open > 7 * all; }
};

std::vector<LowerEnds> lowerEnds(const InverseDepth& grid, const Segmentation& segments) {
  std::vector<LowerEnds> ends(segments.sizes.size());
  for (int v = 0; v + 1 < grid.camera.height; ++v)
    for (int u = 0; u < grid.camera.width; ++u) {
      const std::size_t i = grid.at(u, v), below = grid.at(u, v + 1);
      const std::uint32_t label = segments.labels[i];
      if (label == 0 || segments.labels[below] == label || !(grid.raw[below] > 0)) continue;
      ++ends[label].all;
      ends[label].open += grid.raw[i] - grid.raw[below] >= depthStep * grid.raw[below] ? 1 : 0;
    }
  return ends;
}

/// The parts of furniture: joins what touches a body or carries one, unless it stands on it. Life cycle: the
/// constructor measures the segments, then assemble() once. Invariant: shapes, ends, depths and things have
/// one entry a segment, entry 0 unused; after joinShapes() that of a set's root describes the whole set.
class Assembly {
 public:
  Assembly(const InverseDepth& grid, const HalfImage& half, const SegmentColors& colors, const cv::Vec3d& up,
           const Segmentation& segments)
      : edges_(segmentGraph(grid, segments, up, colors)),
        shapes_(shapesOf(grid, half, up, segments)),
        ends_(lowerEnds(grid, segments)),
        things_(shapes_.size()),
        sets_(shapes_.size()) {
    depths_.resize(shapes_.size());
    for (std::size_t i = 0; i < segments.labels.size(); ++i)
      if (const std::uint32_t label = segments.labels[i]; label != 0) depths_[label] += 1 / grid.raw[i];
    for (std::size_t i = 1; i < depths_.size(); ++i)
      depths_[i] /= std::max<std::uint32_t>(segments.sizes[i], 1);
  }

  DisjointSets& assemble() {
    for (const SegmentEdge& e : edges_) {
      if (!touch(e)) continue;
      if (!shapes_[e.a].isBody() && stands(e.a, e.b, e)) things_[e.a] = 1;
      if (!shapes_[e.b].isBody() && stands(e.b, e.a, e)) things_[e.b] = 1;
    }
    for (const SegmentEdge& e : edges_)
      if (touch(e) && areParts(e) && !stands(e.a, e.b, e) && !stands(e.b, e.a, e)) sets_.join(e.a, e.b);
    for (std::uint32_t top = 1; top < shapes_.size(); ++top) joinWhatCarries(top);
    joinShapes();
    for (std::uint32_t top = 1; top < shapes_.size(); ++top) joinSupport(top);
    return sets_;
  }

 private:
  bool touch(const SegmentEdge& e) const {
    return e.a != 0 && e.contacts >= minBorderPairs && (shapes_[e.a].isBody() || shapes_[e.b].isBody());
  }
  bool areParts(const SegmentEdge& e) const {
    const bool bodies = shapes_[e.a].isBody() && shapes_[e.b].isBody();
    return things_[e.a] == 0 && things_[e.b] == 0 && (bodies || e.contrast < colorEdge);
  }
  bool stands(std::uint32_t a, std::uint32_t b, const SegmentEdge& e) const {
    return standsOn(shapes_[a], shapes_[b], e.height, heightBand + heightNoise * depths_[a] * depths_[a]);
  }
  /// Legs and drawers below the top of a table.
  void joinWhatCarries(std::uint32_t top) {
    const SegmentShape& shape = shapes_[top];
    const auto level = static_cast<std::size_t>(std::ranges::count(shape.level, 1));
    if (!shape.known() || !shape.isBody() || 3 * level < shape.points.size()) return;
    const auto hull = levelHull(shape, -HUGE_VAL, HUGE_VAL);
    if (hull.empty()) return;
    for (std::uint32_t i = 1; i < shapes_.size(); ++i) {
      const SegmentShape& below = shapes_[i];
      if (i == top || things_[i] != 0 || !below.known() || below.high > shape.high + heightBand ||
          below.high < shape.high - maxBelow)
        continue;
      if (shareWithin(below, hull, -heightBand) > 0.6) sets_.join(i, top);
    }
  }

  /// Gives each set the shape of all its segments.
  void joinShapes() {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    for (std::uint32_t i = 1; i < shapes_.size(); ++i) {
      const std::uint32_t set = sets_.find(i);
      if (set == i) continue;
      append(shapes_[set].points, shapes_[i].points);
      append(shapes_[set].level, shapes_[i].level);
      shapes_[set].smooth += shapes_[i].smooth;
      ends_[set].open += ends_[i].open;
      ends_[set].all += ends_[i].all;
      things_[set] |= things_[i];
      shapes_[i] = {};
    }
    for (SegmentShape& shape : shapes_) measureShape(shape);
  }
  /// Joins a wide upper part with free lower ends to a narrower support that ends where it begins: seat and
  /// base, crown and stem, flowers and vase. Things do not float, nor stand on a support that is so much
  /// narrower.
  void joinSupport(std::uint32_t top) {
    const SegmentShape& shape = shapes_[top];
    if (!shape.known() || things_[top] != 0 || !ends_[top].areFree()) return;
    const double stem = (shape.isLeaves() ? stemWidthRatio : widthRatio) * shape.wide;
    std::vector<cv::Point2f> feet, hull;
    for (const cv::Vec3d& p : shape.points) feet.push_back(foot(p));
    cv::convexHull(feet, hull);
    for (std::uint32_t i = 1; i < shapes_.size(); ++i) {
      const SegmentShape& below = shapes_[i];
      const double band = nextTo + heightNoise * depths_[i] * depths_[i];
      if (i == top || !below.known() || std::abs(below.high - shape.low) > band || below.wide > stem ||
          (things_[i] != 0 && below.low > shape.low))
        continue;
      if (shareWithin(below, hull, -nextTo) > 0.6) sets_.join(i, top);
    }
  }

  std::vector<SegmentEdge> edges_;
  std::vector<SegmentShape> shapes_;
  std::vector<LowerEnds> ends_;
  std::vector<double> depths_;
  std::vector<std::uint8_t> things_;
  DisjointSets sets_;
};

}  // namespace

void joinLoose(const InverseDepth& grid, const Mask& mask, const HalfImage& half, const cv::Vec3d& up,
               Segmentation& segments) {
  const std::vector<SegmentShape> shapes = shapesOf(grid, half, up, segments);
  const std::vector<SegmentEdge> edges = segmentGraph(grid, segments, up);
  const std::vector<LowerEnds> ends = lowerEnds(grid, segments);
  const std::vector<std::uint32_t>& sizes = segments.sizes;
  std::vector<std::size_t> around(sizes.size()), atBounds(sizes.size());
  for (const SegmentEdge& e : edges) {
    for (const std::uint32_t i : {e.a, e.b}) around[i] += e.contacts + e.aInFront + e.bInFront;
    if (e.a == 0) atBounds[e.b] += e.contacts;
  }
  const auto isLoose = [&](std::uint32_t i) { return ends[i].areFree() && 5 * atBounds[i] < around[i]; };
  DisjointSets sets(sizes.size());
  std::vector<float> nearest(sizes.size(), nextTo);
  std::vector<std::uint32_t> to(sizes.size());
  for (const SegmentEdge& e : edges) {
    if (e.a == 0) continue;
    if (std::max(sizes[e.a], sizes[e.b]) < grid.area(minSegmentArea) && e.gap < crumbGap) sets.join(e.a, e.b);
    for (const auto& [part, whole] : {std::pair(e.a, e.b), std::pair(e.b, e.a)}) {
      if (e.gap >= nearest[part] || sizes[part] > loose * sizes[whole] || !isLoose(part) ||
          isOnTop(shapes[part], shapes[whole], heightBand))
        continue;
      nearest[part] = e.gap;
      to[part] = whole;
    }
  }
  for (std::uint32_t i = 1; i < to.size(); ++i)
    if (to[i] != 0) sets.join(i, to[i]);
  renumber(mask, segments, sets);
}

void assembleFurniture(const InverseDepth& grid, const Mask& mask, const HalfImage& half,
                       const SegmentColors& colors, const cv::Vec3d& up, Segmentation& segments) {
  Assembly assembly(grid, half, colors, up, segments);
  renumber(mask, segments, assembly.assemble());
}

}  // namespace estancia
