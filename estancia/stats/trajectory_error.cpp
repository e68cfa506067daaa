// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/core/affine.hpp>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"

namespace estancia {
namespace {

void requirePairs(std::span<const Pose> estimated, std::span<const Pose> truth) {
  if (estimated.size() != truth.size() || estimated.empty())
    fail(ErrorCode::mismatch, "there are {} estimated poses and {} true ones; give both at the same times",
         estimated.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (!estimated[i].isPlausible() || !truth[i].isPlausible())
      fail(ErrorCode::invalidInput,
           "pose {} is not finite, or beyond 10 000 km; leave it out of the estimate and of the truth", i);
}

cv::Vec3d positionOf(const Pose& pose) {
  return {pose.x, pose.y, pose.z};
}

cv::Vec3d centerOf(std::span<const Pose> poses) {
  cv::Vec3d sum;
  for (const Pose& pose : poses) sum += positionOf(pose);
  return sum * (1.0 / static_cast<double>(poses.size()));
}

/// Umeyama 1991, Eq. 38–42 without the scale.
cv::Affine3d alignment(std::span<const Pose> from, std::span<const Pose> to) {
  const cv::Vec3d fromCenter = centerOf(from), toCenter = centerOf(to);
  cv::Matx33d covariance = cv::Matx33d::zeros();
  for (std::size_t i = 0; i < from.size(); ++i)
    covariance += (positionOf(to[i]) - toCenter) * (positionOf(from[i]) - fromCenter).t();
  cv::Matx31d w;
  cv::Matx33d u, vt;
  cv::SVD::compute(covariance, w, u, vt);
  const double mirrored = cv::determinant(u) * cv::determinant(vt) < 0 ? -1 : 1;
  const cv::Matx33d rotation = u * cv::Matx33d::diag({1, 1, mirrored}) * vt;
  return {rotation, toCenter - rotation * fromCenter};
}

}  // namespace

AbsoluteTrajectoryError absoluteTrajectoryError(std::span<const Pose> estimated,
                                                std::span<const Pose> truth) {
  requirePairs(estimated, truth);
  const cv::Affine3d aligned = alignment(estimated, truth);
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i)
    errors.push_back(cv::norm(aligned * positionOf(estimated[i]) - positionOf(truth[i])));
  std::ranges::sort(errors);
  const auto count = static_cast<double>(errors.size());
  const std::size_t middle = errors.size() / 2;
  return {.poses = errors.size(),
          .rmse = std::sqrt(std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0) / count),
          .mean = std::accumulate(errors.begin(), errors.end(), 0.0) / count,
          .median = errors.size() % 2 == 1 ? errors[middle] : (errors[middle - 1] + errors[middle]) / 2,
          .max = errors.back(),
          .truthFromEstimate = poseOf(aligned)};
}

RelativePoseError relativePoseError(std::span<const Pose> estimated, std::span<const Pose> truth,
                                    std::size_t step) {
  requirePairs(estimated, truth);
  if (step == 0) throw Error(ErrorCode::invalidInput, "the step is 0 poses; give at least 1");
  RelativePoseError error;
  double translation = 0, rotation = 0;
  for (std::size_t i = 0; i + step < truth.size(); ++i, ++error.pairs) {
    const auto motion = [i, step](std::span<const Pose> poses) {
      return rigidOf(poses[i]).inv() * rigidOf(poses[i + step]);
    };
    const cv::Affine3d difference = motion(truth).inv() * motion(estimated);
    translation += difference.translation().dot(difference.translation());
    rotation += std::pow(angleOf(difference), 2);
  }
  if (error.pairs == 0) return error;
  const auto pairs = static_cast<double>(error.pairs);
  error.translationRmse = std::sqrt(translation / pairs);
  error.rotationRmse = std::sqrt(rotation / pairs) * 180 / std::numbers::pi;
  return error;
}

double pathLength(std::span<const Pose> poses) {
  double length = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) length += distanceBetween(poses[i - 1], poses[i]);
  return length;
}

}  // namespace estancia
