// The things that stand about in a scene: what is left without its planes, taken apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Lengths that noise decides hold at 1 m from the camera and grow with the square of the distance, as the
/// noise of depth cameras does.
struct ClusterOptions {
  /// A plane has at least this [m²] in one patch, of which half may lie beyond the edge of the image: tables,
  /// walls, floors; > 0.
  double planeArea = 0.25;
  double planeTolerance = 0.01;  ///< points so near to a plane belong to it [m at 1 m]; > 0
  double crease = 0.0022;        ///< how deep a concave crease is that parts two things [m at 1 m]; > 0
  double join = 0.02;            ///< pieces so near to each other touch [m]; > 0
  /// Points of a cluster, in an image with a focal length of 525 pixels; as it is for a cloud that is not
  /// organized.
  std::size_t least = 400;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one a usable core; the result does not depend on it
};

struct Plane {
  cv::Vec3d normal;   ///< of unit length, towards the camera
  double offset = 0;  ///< normal · X = offset on the plane [m]
  double area = 0;    ///< of it that was seen [m²]
};

struct Cluster {
  std::vector<std::uint32_t> points;  ///< of the cloud, or pixels of the depth image row by row; ascending
  cv::Rect box;                       ///< of its pixels; empty when there was no grid to go by
  cv::Point3f center;                 ///< mean of its points [m]
  bool atBorder = false;              ///< cut by the edge of the image: part of it may be missing
  bool flat = false;  ///< one plane holds it all within the noise: an image of something, or a single face
};

struct Clusters {
  std::vector<Plane> planes;
  std::vector<Cluster> clusters;  ///< largest first; none is no error
};

/// Takes apart what a depth image (CV_32F, meters, 0 or NaN where there is none) shows: planes are left
/// out, and the rest is cut at edges in depth and at concave creases (Stein et al., CVPR 2014), then joined
/// where something nearer or the rim of a vessel had cut one thing in two. Depths are within a millimeter and
/// a kilometer, or none. `camera` may have images of another size. Throws Error on another type of image,
/// on a camera without size or focal length, and on options out of range.
Clusters findClusters(const cv::Mat& depth, const CameraIntrinsics& camera,
                      const ClusterOptions& options = {});

/// The same of any cloud: on its grid where it is organized and a pinhole camera explains that, else by its
/// points alone, which is slower and coarser: what something nearer cuts in two stays so. A point that is not
/// finite is in no cluster, nor is one of a cloud without a grid beyond 10⁹ m. Throws Error on a cloud that
/// is not whole and on options out of range.
Clusters findClusters(const PointCloud& cloud, const ClusterOptions& options = {});

/// These points of the cloud with their colors and normals, not organized. Throws Error on a point that it
/// does not have.
PointCloud pointsOf(const PointCloud& cloud, const std::vector<std::uint32_t>& points);

/// Whether one plane holds the cloud within the noise of a depth camera that stood at its viewpoint (95 % of
/// it within 4 mm at 1 m; small things far away cannot be told from it): an image of something, or a single
/// face of it. False for fewer than 50 points.
bool isFlat(const PointCloud& cloud);

}  // namespace estancia
