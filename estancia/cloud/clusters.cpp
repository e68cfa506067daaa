#include "estancia/cloud/clusters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "estancia/cloud/inverse_depth.hpp"
#include "estancia/cloud/merge_containers.hpp"
#include "estancia/cloud/merge_segments.hpp"
#include "estancia/cloud/plane_fit.hpp"
#include "estancia/cloud/planes.hpp"
#include "estancia/cloud/segments.hpp"
#include "estancia/cloud/unorganized_clusters.hpp"
#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

void requireSound(const ClusterOptions& options) {
  const auto positive = [](const char* name, double value) {
    if (!(value > 0) || !std::isfinite(value))
      throw Error(fmt::format("{} cannot be {}; give a number above 0", name, value));
  };
  positive("the area of a plane", options.planeArea);
  positive("the tolerance of a plane", options.planeTolerance);
  positive("the depth of a crease", options.crease);
  positive("the distance of pieces that touch", options.join);
  if (options.threads < 0)
    throw Error(fmt::format("{} threads are none; give 0 for as many as there are cores", options.threads));
}

/// What of the image has depth: cameras often see none along its edge.
cv::Rect fieldOf(const InverseDepth& grid) {
  constexpr int share = 20;  // of the image: what is missing beyond is no edge of the camera's
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

/// Some of the points at which all around is of the same piece: those at its rim are mixed with what is
/// behind.
std::vector<cv::Point3f> innerPoints(const InverseDepth& grid, const Segmentation& pieces,
                                     const Cluster& cluster) {
  constexpr double rim = 2;  // pixels
  constexpr std::size_t most = 2000;
  const std::ptrdiff_t across = grid.pixels(rim), down = across * grid.stride;
  const std::ptrdiff_t around[] = {across,        -across,       down,           -down,
                                   across + down, across - down, -across - down, -across + down};
  std::vector<cv::Point3f> inner;
  const std::size_t every = 1 + cluster.points.size() / most;
  for (std::size_t i = 0; i < cluster.points.size(); i += every) {
    const std::uint32_t p = cluster.points[i];
    const auto width = static_cast<std::uint32_t>(grid.camera.width);
    const int u = static_cast<int>(p % width), v = static_cast<int>(p / width);
    const auto at = static_cast<std::ptrdiff_t>(grid.at(u, v));
    const std::uint32_t label = pieces.labels[static_cast<std::size_t>(at)];
    if (std::ranges::all_of(around, [&](std::ptrdiff_t step) {
          return pieces.labels[static_cast<std::size_t>(at + step)] == label;
        }))
      inner.push_back(grid.point(u, v));
  }
  return inner;
}

/// Fills in all but the points.
void describe(const InverseDepth& grid, const Segmentation& pieces, const cv::Rect& field, Cluster& cluster) {
  constexpr int edge = 2;  // pixels
  const auto width = static_cast<std::uint32_t>(grid.camera.width);
  int left = grid.camera.width, right = 0, top = grid.camera.height, bottom = 0;
  cv::Point3d sum;
  for (const std::uint32_t p : cluster.points) {
    const int u = static_cast<int>(p % width), v = static_cast<int>(p / width);
    left = std::min(left, u);
    right = std::max(right, u);
    top = std::min(top, v);
    bottom = std::max(bottom, v);
    sum += cv::Point3d(grid.point(u, v));
  }
  cluster.box = {left, top, right - left + 1, bottom - top + 1};
  cluster.center = sum / static_cast<double>(cluster.points.size());
  cluster.atBorder = left < field.x + edge || top < field.y + edge || right >= field.br().x - edge ||
                     bottom >= field.br().y - edge;
  cluster.flat = isPlanar(innerPoints(grid, pieces, cluster), cluster.center.z);
}

std::vector<Cluster> clustersOf(const InverseDepth& grid, const Mask& mask, const Segmentation& pieces,
                                const ClusterOptions& options) {
  const double enough = std::max(1., grid.area(static_cast<double>(options.least)));
  std::vector<Cluster> clusters;
  std::vector<std::uint32_t> numbers(pieces.sizes.size());
  for (std::size_t i = 1; i < pieces.sizes.size(); ++i) {
    if (pieces.sizes[i] < enough) continue;
    clusters.emplace_back().points.reserve(pieces.sizes[i]);
    numbers[i] = static_cast<std::uint32_t>(clusters.size());
  }
  for (int v = 0; v < grid.camera.height; ++v) {
    const auto [first, last] = mask.rows[static_cast<std::size_t>(v)];
    const std::size_t before =
        grid.at(0, v) - static_cast<std::size_t>(v) * static_cast<std::size_t>(grid.camera.width);
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t number = numbers[pieces.labels[i]];
      if (number != 0) clusters[number - 1].points.push_back(static_cast<std::uint32_t>(i - before));
    }
  }
  std::ranges::stable_sort(clusters, std::ranges::greater{},
                           [](const Cluster& c) { return c.points.size(); });
  const cv::Rect field = fieldOf(grid);
  inParallel(clusters.size(), static_cast<std::size_t>(options.threads > 0 ? options.threads : usableCores()),
             [&](std::size_t i) { describe(grid, pieces, field, clusters[i]); });
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

/// The camera that saw an organized cloud; none where no pinhole camera did.
std::optional<CameraIntrinsics> cameraOf(const PointCloud& cloud) {
  constexpr double mostResidual = 0.5;  // pixels
  if (!cloud.organized() || cloud.width > std::numeric_limits<int>::max() / cloud.height) return {};
  LineFit across, down;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const cv::Point3f& p = cloud.points[i];
    if (!isFinite(p)) continue;
    if (!(p.z > 0)) return {};
    const std::size_t column = i % cloud.width, row = i / cloud.width;
    across.add(static_cast<double>(p.x) / p.z, static_cast<double>(column));
    down.add(static_cast<double>(p.y) / p.z, static_cast<double>(row));
  }
  const CameraIntrinsics camera{static_cast<int>(cloud.width),
                                static_cast<int>(cloud.height),
                                across.focal(),
                                down.focal(),
                                across.center(),
                                down.center()};
  const bool explained = camera.fx > 0 && camera.fy > 0 &&
                         std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy) &&
                         across.residual() <= mostResidual && down.residual() <= mostResidual;
  return explained ? std::optional(camera) : std::nullopt;
}

}  // namespace

Clusters findClusters(const cv::Mat& depth, const CameraIntrinsics& camera, const ClusterOptions& options) {
  requireSound(options);
  const InverseDepth grid = inverseDepth(depth, camera, options.threads);
  WithoutPlanes scene = removePlanes(grid, options);
  std::vector<std::uint8_t> creases = concaveCreases(grid, scene.rest, options.crease, options.threads);
  Segmentation pieces = oversegment(grid, scene.rest, std::move(creases));
  mergeSegments(grid, scene.rest, options.join, options.threads, pieces);
  mergeContainerInteriors(grid, scene.rest, scene.planes, options.threads, pieces);
  std::vector<Cluster> clusters = clustersOf(grid, scene.rest, pieces, options);
  return {std::move(scene.planes), std::move(clusters)};
}

Clusters findClusters(const PointCloud& cloud, const ClusterOptions& options) {
  requireSound(options);
  validate(cloud);
  const auto camera = cameraOf(cloud);
  if (!camera) return findUnorganizedClusters(cloud, options);
  cv::Mat depth(camera->height, camera->width, CV_32F);
  std::ranges::transform(cloud.points, depth.ptr<float>(),
                         [](const cv::Point3f& p) { return isFinite(p) ? p.z : 0; });
  return findClusters(depth, *camera, options);
}

PointCloud pointsOf(const PointCloud& cloud, const std::vector<std::uint32_t>& points) {
  validate(cloud);
  PointCloud part;
  part.width = points.size();
  part.height = 1;
  part.viewpoint = cloud.viewpoint;
  for (const std::uint32_t i : points) {
    if (i >= cloud.points.size())
      throw Error(fmt::format("a cloud of {} points has no point {}; these points are another cloud's",
                              cloud.points.size(), i));
    part.points.push_back(cloud.points[i]);
    if (!cloud.colors.empty()) part.colors.push_back(cloud.colors[i]);
    if (!cloud.normals.empty()) part.normals.push_back(cloud.normals[i]);
  }
  return part;
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
