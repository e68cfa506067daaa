// SPDX-License-Identifier: Apache-2.0
#include "estancia/cloud/normals.hpp"

#include <limits>

#include "estancia/cloud/covariance.hpp"
#include "estancia/cloud/neighbors.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

cv::Point3f normalAt(const cv::Point3f& place, const LocalCovariance& local, const cv::Point3f& viewpoint) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  if (local.count < 3) return {none, none, none};
  const cv::Vec3d normal = principalAxes(local.covariance).normal;
  const cv::Vec3d look =
      cv::Vec3d(viewpoint.x, viewpoint.y, viewpoint.z) - cv::Vec3d(place.x, place.y, place.z);
  return cv::Point3d(normal.dot(look) < 0 ? -normal : normal);
}

}  // namespace

OptionGroup declare(NormalOptions& o) {
  OptionGroup group("normals", "Surface normals.");
  group.add("radius", &o.radius, "Radius of the points that a plane is fitted to; 0: neighbors decides")
      .range(0)
      .unit("m")
      .why("Larger radii average noise away and round edges off.");
  group.add("neighbors", &o.neighbors, "Nearest points that a plane is fitted to; 0: radius decides");
  group.add("threads", &o.threads, "Threads; 0: one a usable core").range(0);
  return group;
}

void validate(const NormalOptions& options) {
  NormalOptions copy = options;
  declare(copy).validate();
  if ((options.radius > 0) == (options.neighbors > 0))
    fail(ErrorCode::invalidOption,
         "normals.radius is {} m and normals.neighbors is {}; give exactly one above 0", options.radius,
         options.neighbors);
}

std::vector<cv::Point3f> estimateNormals(const PointCloud& cloud, const NormalOptions& options) {
  return estimateNormals(cloud.points, Neighbors(cloud.points, options.threads), options);
}

std::vector<cv::Point3f> estimateNormals(std::span<const cv::Point3f> places, const Neighbors& points,
                                         const NormalOptions& options) {
  validate(options);
  const auto fixed = static_cast<float>(options.radius * options.radius);
  std::vector<cv::Point3f> normals(places.size());
  constexpr std::size_t together = 512;
  inParallel((places.size() + together - 1) / together, options.threads, Progress::none(),
             "stopped while normals were estimated", [&](std::size_t chunk) {
               std::vector<Neighbor> buffer;
               const std::size_t end = std::min(places.size(), (chunk + 1) * together);
               for (std::size_t i = chunk * together; i < end; ++i) {
                 float squared = fixed;
                 if (options.neighbors > 0) {
                   const auto near = points.nearest(places[i], options.neighbors, buffer);
                   squared = near.empty() ? -1 : near.back().squared;
                 }
                 normals[i] =
                     normalAt(places[i], localCovariance(points, places[i], squared), options.viewpoint);
               }
             });
  return normals;
}

}  // namespace estancia
