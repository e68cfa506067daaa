// Surface normals and planes: fitted to points by PCA, oriented towards the viewpoint.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"

namespace estancia {

class Neighbors;
struct NeuralGas;

struct LocalCovariance {
  std::size_t count = 0;
  cv::Vec3d offset;        ///< from the place to the mean of the points [m]
  cv::Matx33d covariance;  ///< covariance of the points [m²], divided by their number
};

/// Covariance of the points at most √squared [m] away. Sums are relative to the place, so that they are as
/// exact far from the origin as near it.
LocalCovariance localCovariance(const Neighbors& points, const cv::Point3f& place, float squared);

/// Eigenvalues of a covariance, smallest first, and the eigenvector of the smallest.
struct PrincipalAxes {
  std::array<double, 3> variances{};
  cv::Vec3d normal;  ///< direction of the smallest variance, unit length; NaN for collinear points
};

/// In closed form (O. K. Smith: Eigenvalues of a symmetric 3 × 3 matrix. CACM 4(4), 1961).
PrincipalAxes principalAxes(const cv::Matx33d& covariance);

struct PlaneFit {
  cv::Vec3d center, normal;  ///< the normal is of unit length
  double distance(const cv::Point3f& p) const { return (cv::Vec3d(p.x, p.y, p.z) - center).dot(normal); }
};

/// The plane (total least squares) of finite points; none when they are fewer than three or `minPoints`, or
/// collinear.
std::optional<PlaneFit> fitPlane(std::span<const cv::Point3f> points, std::size_t minPoints = 3);

/// Whether 95 % of the points lie within 4 mm of one plane, the noise of depth cameras at 1 m; at `distance`
/// [m] the tolerance grows with its square. False for fewer than 50 points.
bool isPlanar(std::vector<cv::Point3f> points, double distance);

/// Exactly one of radius and neighbors must be given.
struct NormalOptions {
  /// Radius of the neighborhood that a plane is fitted to [m]; 0: `neighbors` decides.
  double radius = 0;
  /// Number of nearest points, together with those at the distance of the last; 0: `radius` decides.
  std::size_t neighbors = 0;
  /// Position of the sensor, towards which normals point.
  cv::Point3f viewpoint{0, 0, 0};
  /// 0: one a usable core. The result does not depend on it.
  int threads = 0;
};
OptionGroup declare(NormalOptions& options);
/// Throws Error (invalidOption) on options out of range, and unless exactly one of the two is given.
void validate(const NormalOptions& options);

/// The normal of each point of a cloud: the direction in which the points around it vary least (Hoppe et
/// al., SIGGRAPH 1992; Rusu 2010). Unit vectors towards the viewpoint; NaN where a point is not finite, has
/// fewer than three points around it, or these lie on a line. Throws Error (invalidOption).
std::vector<cv::Point3f> estimateNormals(const PointCloud& cloud, const NormalOptions& options);

/// Normals at given positions, with a shared search tree.
std::vector<cv::Point3f> estimateNormals(std::span<const cv::Point3f> places, const Neighbors& points,
                                         const NormalOptions& options);

/// Gives neighboring normals the same side along the minimum spanning tree of their angles (Hoppe et al.,
/// SIGGRAPH 1992): a closed surface gets all outwards or all inwards, and each connected surface keeps the
/// side of its first point. `neighbors` are those of `points`. Throws Error (invalidInput) unless there is
/// one normal a point.
void orientConsistently(std::span<const cv::Point3f> points, const Neighbors& neighbors,
                        std::vector<cv::Point3f>& normals);

/// A unit normal for every neuron of a neural gas: PCA of the neuron, its neighbors and theirs, oriented
/// towards `viewpoint`. It needs no radius, because the graph joins what lies on one surface. NaN where these
/// points do not span a plane. O(neurons). Throws Error (invalidInput) on an edge beyond the neurons.
std::vector<cv::Point3f> normalsFromGraph(const NeuralGas& gas, const cv::Point3f& viewpoint = {0, 0, 0});

}  // namespace estancia
