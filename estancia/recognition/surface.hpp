// Oriented surface: points with normals and a search tree, and the keypoints on it (thesis 2.4.2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <span>
#include <string>
#include <vector>

#include "estancia/cloud/neighbors.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

/// Points with normals. Immutable and thread-safe. Invariant: normals, and colors where there are any, have
/// one entry a point, and all values are finite.
class Surface {
 public:
  /// Keeps the points of `cloud` that are finite and have a finite normal. `name` is for messages. Throws
  /// Error (invalidInput), naming the cloud, when none is left.
  Surface(std::string name, const PointCloud& cloud, int threads = 1);

  const std::string& name() const { return name_; }
  std::size_t size() const { return points_.size(); }
  const std::vector<cv::Point3f>& points() const { return points_; }    ///< [m]
  const std::vector<cv::Point3f>& normals() const { return normals_; }  ///< unit vectors
  /// CIELAB; empty when the cloud has no colors.
  const std::vector<cv::Vec3f>& lab() const { return lab_; }
  const Neighbors& neighbors() const { return neighbors_; }  ///< search tree of points()

  double resolution() const { return resolution_; }  ///< median distance of a point to the nearest other [m]
  double extent() const { return extent_; }          ///< diagonal of the box around the points [m]

  /// Replaces the normals, one a point.
  Surface withNormals(std::vector<cv::Point3f> normals) const;

 private:
  std::string name_;
  std::vector<cv::Point3f> points_, normals_;
  std::vector<cv::Vec3f> lab_;
  Neighbors neighbors_;
  double resolution_ = 0, extent_ = 0;
};

/// Points [m] with unit normals of a model that is tried in a scene. `weights` are those of the pose score;
/// empty: all 1.
struct OrientedPoints {
  std::vector<cv::Point3f> points, normals;
  std::vector<float> weights;
  std::vector<cv::Vec3f> lab = {};  ///< CIELAB; empty: no colors
};

/// About `count` points, evenly spread over a surface; all when it has no more.
OrientedPoints spreadPoints(const Surface& surface, std::size_t count);

/// One point a voxel of edge `spacing` [m], `most` at most: a part of the voxels.
OrientedPoints spreadPointsBy(const Surface& surface, double spacing,
                              std::size_t most = std::numeric_limits<std::size_t>::max());

/// At most `count` of the indices, evenly.
std::vector<std::uint32_t> partOf(std::vector<std::uint32_t> indices, std::size_t count);

/// Throws Error (invalidOption, mismatch, invalidInput, insufficientData) unless `radius` [m] is finite,
/// positive, contains some neighbors of most of `points`, and is smaller than their extent: else it is
/// probably in other units, and the message advises a radius. `name` is the cloud's, `what` the radius':
/// "descriptor radius".
void requireRadius(const std::string& name, std::span<const cv::Point3f> points, const Neighbors& neighbors,
                   double radius, const std::string& what);

/// Diagonal of the bounding box of points [m]; 0 when there are none.
double extentOf(std::span<const cv::Point3f> points);

/// Centroid [m].
cv::Point3d meanOf(std::span<const cv::Point3f> points);

/// The detectors by name: uniform, harris3d, iss.
Choices keypointMethods();

/// Keypoints of a surface as ascending indices of its points. `spacing` [m] is
///   uniform   the edge of the voxels, each of which gives its point nearest to the mean of its points
///   harris3d  the radius of the covariance of normals (Sipiran and Bustos 2011 as in PCL, det − 0.04 tr²)
///             and of non-maximum suppression
///   iss       the radius of the scatter matrix (Zhong 2009; both ratios of its eigenvalues below 0.975);
///             non-maximum suppression of the smallest eigenvalue within 2/3 of it
/// Throws Error (unknownName, invalidOption) on an unknown method and on a spacing that is not positive, or
/// far below the resolution.
std::vector<std::uint32_t> findKeypoints(const Surface& surface, const std::string& method, double spacing,
                                         int threads = 1);

}  // namespace estancia
