#include "estancia/cloud/normals.hpp"

#include <cmath>
#include <limits>

#include "estancia/cloud/covariance.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace {

cv::Point3f normalAt(const cv::Point3f& place, const LocalCovariance& spread, const cv::Point3f& viewpoint) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  if (spread.count < 3) return {none, none, none};
  const cv::Vec3d normal = principalAxes(spread.covariance).normal;
  const cv::Vec3d look =
      cv::Vec3d(viewpoint.x, viewpoint.y, viewpoint.z) - cv::Vec3d(place.x, place.y, place.z);
  return cv::Point3d(normal.dot(look) < 0 ? -normal : normal);
}

}  // namespace

std::vector<cv::Point3f> estimateNormals(std::span<const cv::Point3f> places, const Neighbors& points,
                                         const NormalOptions& options) {
  if ((options.radius > 0) == (options.neighbors > 0) || !std::isfinite(options.radius))
    throw Error("normals need the radius or the number of the points around; give one of the two, above 0");
  const auto fixed = static_cast<float>(options.radius * options.radius);
  std::vector<cv::Point3f> normals(places.size());
  constexpr std::size_t together = 512;
  Progress silent;
  inParallel((places.size() + together - 1) / together, options.threads, silent,
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
