// Object segmentation: clusters of a depth image or cloud by plane removal, convexity and merging.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Lengths that depend on noise hold at 1 m from the camera and grow with the square of the distance, as the
/// noise of depth cameras does.
struct ClusterOptions {
  enum class Method {
    /// Convex parts (Stein et al., CVPR 2014).
    convexity,
    /// Euclidean clusters of a depth image, as the thesis has them (6.3.1; Rusu, Semantic 3D Object Maps,
    /// 2009):
    /// voxels of 5 mm that lie 20 mm from all planes are one object within 15 mm, of 100 to 25,000 voxels.
    euclidean
  };
  Method method = Method::convexity;
  /// Area of the smallest plane that is removed [m²], of which half may lie beyond the image's edge.
  double minPlaneArea = 0.25;
  /// Distance within which points belong to a plane [m].
  static constexpr double planeTolerance = 0.01;
  /// Depth of the concave creases that separate objects [m].
  static constexpr double creaseDepth = 0.0022;
  std::size_t minPoints = 400;
  /// Seed of the search for planes.
  std::uint64_t seed = 1;
  int threads = 0;
};
/// Declares the options, their units and their ranges.
OptionGroup declare(ClusterOptions& options);

struct Plane {
  /// Unit length, towards the camera.
  cv::Vec3d normal;
  /// normal · X = offset on the plane [m].
  double offset = 0;
  /// The visible part [m²].
  double area = 0;
  /// Bounds the room (floor, wall, ceiling, or the only table in view); else it is a face of a thing, and its
  /// pixels are in clusters.
  bool structural = true;
};

struct Cluster {
  /// Indices of the cloud's points, or of the depth image's pixels row by row; ascending.
  std::vector<std::uint32_t> points;
  /// Bounding box of the pixels; empty for a cloud that is not organized.
  cv::Rect box;
  /// Mean of the points [m].
  cv::Point3f center;
  /// Touches the edge of the image: part of the object may be missing.
  bool atBorder = false;
  /// One plane fits all points within the noise: an image of an object, or a single face.
  bool flat = false;
};

struct Clusters {
  std::vector<Plane> planes;
  /// Largest first; may be empty.
  std::vector<Cluster> clusters;
  /// Unit length, in the camera's frame: upright if the planes determine it, else the image's up. Set for a
  /// depth image or organized cloud.
  cv::Vec3d up = {0, -1, 0};
};

/// Segments a depth image (CV_32F, meters, 0 or NaN where there is none): removes planes, splits the rest at
/// depth edges and concave creases (Stein et al., CVPR 2014), and merges segments of one object that an
/// occluder or the rim of a container had separated. Depths outside of 1 mm to 1 km count as missing.
/// `camera` may have images of another size. `image`, which may be empty, is a BGR image of the same view, of
/// any size: it separates things of one height that touch side by side where their colors differ; Euclidean
/// clusters do not need it. Throws Error (invalidInput, invalidOption) on another type of image, on a camera
/// without size or focal length, and on options out of range.
Clusters findClusters(const cv::Mat& depth, const CameraIntrinsics& camera,
                      const ClusterOptions& options = {}, const cv::Mat& image = {});

/// Clusters a cloud with its colors: on its grid when it is organized and a pinhole camera explains the grid,
/// else from the points alone, which is slower and coarser (objects behind an occluder stay separate). Points
/// that are not finite belong to no cluster, nor do points beyond 10⁹ m in a cloud without a grid. Throws
/// Error (invalidInput, invalidOption) on a cloud that breaks its invariant, on options out of range, and on
/// Euclidean clusters of a cloud without a grid.
Clusters findClusters(const PointCloud& cloud, const ClusterOptions& options = {});

/// Whether one plane fits the cloud within the noise of a depth camera at its viewpoint (95 % of the points
/// within 4 mm at 1 m). Small distant objects look flat, too. False for fewer than 50 points.
bool isFlat(const PointCloud& cloud);

}  // namespace estancia
