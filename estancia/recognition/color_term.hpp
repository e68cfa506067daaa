// Color term: evidence for a pose from the colors of a model and a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "estancia/recognition/surface.hpp"

namespace estancia {

/// Difference of two colors in CIELAB; lightness counts half, as light changes it most (CMC l:c = 2:1,
/// Clarke, McDonald, Rigg 1984).
inline float colorDifference(const cv::Vec3f& a, const cv::Vec3f& b) {
  const cv::Vec3f d = a - b;
  return std::sqrt(d[0] * d[0] / 4 + d[1] * d[1] + d[2] * d[2]);
}

/// How the color changes along a surface [1/m]: row c is the gradient of channel c of CIELAB in the tangent
/// plane of a point, by least squares over the points within `radius` [m]. One a point; empty when the
/// surface has no colors.
std::vector<cv::Matx33f> colorGradients(const Surface& surface, double radius, int threads);

/// The rows of colored ICP beside those of the planes (Park, Zhou, Koltun: Colored point cloud registration
/// revisited, 2017, equation 13): the color of a model point should be that of the scene's surface where it
/// lies. Differences that all points share, of light and exposure, do not count: they are taken from the
/// round before, so the first round has no rows.
class ColorTerm {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /// Colors of the model's points, and of the scene's with their gradients; a difference of `tolerance`
  /// weighs as much as a distance of the reach. Off when `tolerance` is 0, or one has no colors.
  ColorTerm(const std::vector<cv::Vec3f>& model, const Surface& scene,
            const std::vector<cv::Matx33f>* gradients, double tolerance);

  bool on() const { return tolerance_ > 0; }
  /// A partner: the i-th point of the model at `p`, near the k-th of the scene; lever arms are relative to
  /// `middle` and divided by `size` [m].
  void add(std::size_t i, std::size_t k, const cv::Point3f& p, const cv::Point3f& middle, double size,
           double weight, double reach, Matrix6& left, Vector6& right);
  void endRound();

 private:
  const std::vector<cv::Vec3f>& model_;
  const Surface& scene_;
  const std::vector<cv::Matx33f>* gradients_;
  double tolerance_;
  bool first_ = true;
  cv::Vec3d shared_, sum_;
  double weights_ = 0;
};

}  // namespace estancia
