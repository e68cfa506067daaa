// SPDX-License-Identifier: Apache-2.0
#include "estancia/segmentation/clusters.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "estancia/cloud/normals.hpp"
#include "estancia/core/cores.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/segmentation/segmentation_stages.hpp"

namespace estancia {
namespace {

/// The part of the image that has depth: cameras often measure none along its edge.
cv::Rect fieldOfView(const InverseDepth& grid) {
  constexpr int share = 20;  // share of the image: a wider margin without depth is not the camera's
  const int width = grid.camera.width, height = grid.camera.height;
  const auto sees = [&](int u, int v) { return grid.raw[grid.at(u, v)] > 0; };
  const auto emptyLines = [&](int lines, int length, const auto& seen) {
    for (int line = 0; line * share <= lines; ++line)
      for (int i = 0; i < length; ++i)
        if (seen(line, i)) return line;
    return 0;
  };
  const int left = emptyLines(width, height, [&](int line, int i) { return sees(line, i); });
  const int right = emptyLines(width, height, [&](int line, int i) { return sees(width - 1 - line, i); });
  const int top = emptyLines(height, width, [&](int line, int i) { return sees(i, line); });
  const int bottom = emptyLines(height, width, [&](int line, int i) { return sees(i, height - 1 - line); });
  return {left, top, width - left - right, height - top - bottom};
}

/// A sample of the points whose neighbors all belong to the same segment: pixels at its rim mix foreground
/// and background.
std::vector<cv::Point3f> innerPoints(const InverseDepth& grid, const Segmentation& segments,
                                     const Cluster& cluster) {
  constexpr double rim = 2;  // pixels
  constexpr std::size_t maxPoints = 2000;
  const std::ptrdiff_t across = grid.pixels(rim), down = across * grid.stride;
  const std::ptrdiff_t around[] = {across,        -across,       down,           -down,
                                   across + down, across - down, -across - down, -across + down};
  std::vector<cv::Point3f> inner;
  const std::size_t every = 1 + cluster.points.size() / maxPoints;
  for (std::size_t i = 0; i < cluster.points.size(); i += every) {
    const std::uint32_t p = cluster.points[i];
    const auto width = static_cast<std::uint32_t>(grid.camera.width);
    const int u = static_cast<int>(p % width), v = static_cast<int>(p / width);
    const auto at = static_cast<std::ptrdiff_t>(grid.at(u, v));
    const std::uint32_t label = segments.labels[static_cast<std::size_t>(at)];
    if (std::ranges::all_of(around, [&](std::ptrdiff_t step) {
          return segments.labels[static_cast<std::size_t>(at + step)] == label;
        }))
      inner.push_back(grid.point(u, v));
  }
  return inner;
}

/// Fills in all members but the points.
void measure(const InverseDepth& grid, const Segmentation& segments, const cv::Rect& field,
             Cluster& cluster) {
  constexpr int edge = 2;  // pixels
  const auto width = static_cast<std::uint32_t>(grid.camera.width);
  cv::Point3d sum;
  for (const std::uint32_t p : cluster.points) {
    const int u = static_cast<int>(p % width), v = static_cast<int>(p / width);
    cluster.box |= cv::Rect(u, v, 1, 1);
    sum += cv::Point3d(grid.point(u, v));
  }
  cluster.center = sum / static_cast<double>(cluster.points.size());
  const cv::Rect inside(field.x + edge, field.y + edge, field.width - 2 * edge, field.height - 2 * edge);
  cluster.atBorder = (cluster.box & inside) != cluster.box;
  cluster.flat = isPlanar(innerPoints(grid, segments, cluster), cluster.center.z);
}

/// The segments that are large enough, largest first.
std::vector<Cluster> clustersOf(const InverseDepth& grid, const Mask& mask, const Segmentation& segments,
                                const ClusterOptions& options) {
  const double minPixels = std::max(1., grid.area(static_cast<double>(options.minPoints)));
  std::vector<Cluster> clusters;
  std::vector<std::uint32_t> numbers(segments.sizes.size());
  for (std::size_t i = 1; i < segments.sizes.size(); ++i) {
    if (segments.sizes[i] < minPixels) continue;
    clusters.emplace_back().points.reserve(segments.sizes[i]);
    numbers[i] = static_cast<std::uint32_t>(clusters.size());
  }
  for (int v = 0; v < grid.camera.height; ++v) {
    const auto [first, last] = mask.rows[static_cast<std::size_t>(v)];
    const std::size_t before =
        grid.at(0, v) - static_cast<std::size_t>(v) * static_cast<std::size_t>(grid.camera.width);
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t number = numbers[segments.labels[i]];
      if (number != 0) clusters[number - 1].points.push_back(static_cast<std::uint32_t>(i - before));
    }
  }
  std::ranges::stable_sort(clusters, std::ranges::greater{},
                           [](const Cluster& c) { return c.points.size(); });
  const cv::Rect field = fieldOfView(grid);
  inParallel(clusters.size(), static_cast<std::size_t>(options.threads > 0 ? options.threads : usableCores()),
             [&](std::size_t i) { measure(grid, segments, field, clusters[i]); });
  return clusters;
}

/// One coordinate of pixels as a pinhole camera sees them: pixel = focal · slope + center.
class LineFit {
 public:
  void add(double slope, double pixel) {
    ++n_;
    x_ += slope;
    y_ += pixel;
    xx_ += slope * slope;
    xy_ += slope * pixel;
    yy_ += pixel * pixel;
  }
  double focal() const { return (n_ * xy_ - x_ * y_) / (n_ * xx_ - x_ * x_); }
  double center() const { return (y_ - focal() * x_) / n_; }
  /// [pixels], root mean square
  double residual() const {
    const double f = focal(), spread = (yy_ - y_ * y_ / n_) - f * (xy_ - x_ * y_ / n_);
    return std::sqrt(std::max(0., spread / n_));
  }

 private:
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0, yy_ = 0;
};

/// The pinhole camera of an organized cloud; none where no pinhole camera explains its grid.
std::optional<CameraIntrinsics> cameraOf(const PointCloud& cloud) {
  if (!cloud.organized() || cloud.width > std::numeric_limits<int>::max() / cloud.height) return {};
  LineFit across, down;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const cv::Point3f& p = cloud.points[i];
    if (!isMeasured(p)) continue;
    if (!(p.z > 0)) return {};
    const std::size_t column = i % cloud.width, row = i / cloud.width;
    across.add(static_cast<double>(p.x) / p.z, static_cast<double>(column));
    down.add(static_cast<double>(p.y) / p.z, static_cast<double>(row));
  }
  const int width = static_cast<int>(cloud.width), height = static_cast<int>(cloud.height);
  const CameraIntrinsics camera{width, height, across.focal(), down.focal(), across.center(), down.center()};
  const bool fits = camera.fx > 0 && camera.fy > 0 &&
                    std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy) &&
                    across.residual() <= 0.5 && down.residual() <= 0.5;  // [pixels]
  return fits ? std::optional(camera) : std::nullopt;
}

}  // namespace

OptionGroup declare(ClusterOptions& o) {
  OptionGroup group("clusters", "Segmentation of a depth image or cloud into objects.");
  group
      .add("min-points", &o.minPoints,
           "Points of the smallest cluster: pixels at a focal length of 525, or points of an unorganized "
           "cloud")
      .why("Lower it for small or distant objects.");
  group.add("threads", &o.threads, "Threads; 0: one a usable core. The result does not depend on it")
      .range(0);
  return group;
}

/// With the member that is no option: planes of no area would never end.
static void requireValid(const ClusterOptions& options) {
  validate(options);
  if (!(options.minPlaneArea > 0 && std::isfinite(options.minPlaneArea)))
    fail(ErrorCode::invalidOption, "the smallest plane has {} m²; give an area above 0",
         options.minPlaneArea);
}

/// Segments by convexity, and their pixels.
static std::pair<Segmentation, Mask> convexSegments(const InverseDepth& grid, const cv::Vec3d& up,
                                                    const cv::Mat& image, const ClusterOptions& options,
                                                    PlaneRemoval& removal) {
  findStructure(grid, up, removal);
  const Segmentation patches = takePatches(grid, removal);
  dropGrazedLevels(grid, up, removal);
  std::vector<std::uint8_t> creases =
      concaveCreases(grid, removal.rest, options.creaseDepth, options.threads);
  Segmentation segments = oversegment(grid, removal.rest, std::move(creases));
  Mask foreground = dropStructure(grid, removal, up, patches, segments);
  mergeSegments(grid, foreground, options.threads, segments);
  joinLoose(grid, foreground, removal.half, up, segments);
  const SegmentColors colors = segmentColors(image, {grid.camera.width, grid.camera.height});
  assembleFurniture(grid, foreground, removal.half, colors, up, segments);
  mergeContainerInteriors(grid, foreground, removal.planes, options.threads, segments);
  if (!colors.empty()) splitByColor(grid, removal.half, colors, up, segments);
  dropFragments(grid, removal, up, foreground, segments);
  dropNarrow(grid, foreground, segments);
  return {std::move(segments), std::move(foreground)};
}

Clusters findClusters(const cv::Mat& depth, const CameraIntrinsics& camera, const ClusterOptions& options,
                      const cv::Mat& image) {
  requireValid(options);
  if (!image.empty() && image.type() != CV_8UC3)
    fail(ErrorCode::invalidInput, "the image beside a depth image is not BGR with 8 bits; convert it");
  const InverseDepth grid = inverseDepth(depth, camera, options.threads);
  PlaneRemoval removal = removePlanes(grid, options);
  const cv::Vec3d up = upOf(removal.planes);
  auto [segments, foreground] = options.method == ClusterOptions::Method::euclidean
                                    ? euclideanSegments(grid, removal.planes, options.threads)
                                    : convexSegments(grid, up, image, options, removal);
  for (const std::uint32_t i : grid.bridged) {  // has no point
    std::uint32_t& label = segments.labels[i];
    if (label != 0) --segments.sizes[label];
    label = 0;
  }
  std::vector<Cluster> clusters = clustersOf(grid, foreground, segments, options);
  return {std::move(removal.planes), std::move(clusters), up};
}

Clusters findClusters(const PointCloud& cloud, const ClusterOptions& options) {
  requireValid(options);
  validate(cloud);
  const auto camera = cameraOf(cloud);
  if (!camera && options.method == ClusterOptions::Method::euclidean)
    fail(ErrorCode::invalidOption, "Euclidean clusters need a depth image or an organized cloud");
  if (!camera) return findUnorganizedClusters(cloud, options);
  cv::Mat depth(camera->height, camera->width, CV_32F);
  std::ranges::transform(cloud.points, depth.ptr<float>(),
                         [](const cv::Point3f& p) { return isMeasured(p) ? p.z : 0; });
  const cv::Mat image = cloud.colors.empty()
                            ? cv::Mat()
                            : cv::Mat(camera->height, camera->width, CV_8UC3,
                                      const_cast<cv::Vec3b*>(cloud.colors.data()));  // is only read
  return findClusters(depth, *camera, options, image);
}

bool isFlat(const PointCloud& cloud) {
  std::vector<cv::Point3f> points;
  cv::Point3d sum;
  for (const cv::Point3f& p : cloud.points) {
    if (!isFinite(p)) continue;
    points.push_back(p);
    sum += cv::Point3d(p);
  }
  if (points.empty()) return false;
  const cv::Point3d from = cloud.viewpoint
                               ? cv::Point3d(cloud.viewpoint->x, cloud.viewpoint->y, cloud.viewpoint->z)
                               : cv::Point3d();
  const double distance = cv::norm(sum / static_cast<double>(points.size()) - from);
  return isPlanar(std::move(points), distance);
}

}  // namespace estancia
