// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/alignment.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/core/rigid.hpp"

namespace estancia::odometry {
namespace {

constexpr double kMinConditioning = 0.004;  // below, depth alone is degenerate (a bare wall, a corridor)
constexpr double kTextured = 4e-4;          // variance of gray values (0 to 1); below, there is no texture
constexpr double kConverged = 1e-4;         // [m] and [rad]: a smaller step is the last of its level

/// Projects every point of the source into the target, for the quality of the alignment.
void evaluate(Alignment& alignment, const PyramidLevel& source, const PyramidLevel& target,
              double sameSurface) {
  std::size_t points = 0, seen = 0, same = 0;
  double squares = 0, sumA = 0, sumB = 0, sumAA = 0, sumBB = 0, sumAB = 0;
  const CameraIntrinsics& c = target.camera;
  cv::Matx66d information = cv::Matx66d::zeros(), planes = cv::Matx66d::zeros();
  for (int y = 0; y < source.points.rows; ++y)
    for (int x = 0; x < source.points.cols; ++x) {
      const cv::Vec3f point = source.points.at<cv::Vec3f>(y, x);
      if (!(point[2] > 0)) continue;
      ++points;
      const cv::Vec3d p = alignment.transform * cv::Vec3d(point);
      if (!(p[2] > 0)) continue;
      const double u = c.fx * p[0] / p[2] + c.cx, v = c.fy * p[1] / p[2] + c.cy;
      if (!(u >= 0 && v >= 0 && u <= c.width - 1 && v <= c.height - 1)) continue;
      const int row = static_cast<int>(std::lround(v)), column = static_cast<int>(std::lround(u));
      const float z = target.depth.at<float>(row, column);
      if (!(z > 0)) continue;
      ++seen;
      const double difference = z - p[2];
      if (std::abs(difference) > sameSurface) continue;
      ++same;
      squares += difference * difference;
      const double rows[] = {0,     p[2],  -p[1], 1, 0, 0,  //
                             -p[2], 0,     p[0],  0, 1, 0,  //
                             p[1],  -p[0], 0,     0, 0, 1};
      const cv::Matx<double, 3, 6> g(rows);
      information += g.t() * g;
      const double a = source.gray.at<float>(y, x), b = target.gray.at<float>(row, column);
      sumA += a, sumB += b, sumAA += a * a, sumBB += b * b, sumAB += a * b;
      const cv::Vec3d n = target.normals.at<cv::Vec3f>(row, column);
      if (!(n[2] <= 1)) continue;  // no normal at an edge
      const cv::Vec3d turned = p.cross(n);
      const cv::Matx61d plane(turned[0], turned[1], turned[2], n[0], n[1], n[2]);
      planes += plane * plane.t();
    }
  if (same == 0) {
    alignment.solved = false;
    return;
  }
  const auto share = [](std::size_t a, std::size_t b) {
    return static_cast<double>(a) / static_cast<double>(b);
  };
  alignment.overlap = share(same, points);
  alignment.inView = share(seen, points);
  cv::Matx61d fixed;
  cv::eigen(planes * (1 / static_cast<double>(same)), fixed);
  alignment.conditioning = fixed(5);
  const auto n = static_cast<double>(same);
  const double varianceA = sumAA / n - sumA * sumA / n / n, varianceB = sumBB / n - sumB * sumB / n / n;
  const bool textured = std::min(varianceA, varianceB) > kTextured;
  alignment.correlation = textured ? (sumAB / n - sumA * sumB / n / n) / std::sqrt(varianceA * varianceB) : 1;
  alignment.rmse = std::sqrt(squares / static_cast<double>(same));
  std::copy(information.val, information.val + 36, alignment.information.begin());
}

}  // namespace

Matrix4 matrixOf(const cv::Affine3d& transform) {
  Matrix4 matrix;
  std::copy(transform.matrix.val, transform.matrix.val + 16, matrix.begin());
  return matrix;
}

cv::Affine3d rigidOf(const Matrix4& matrix) {
  return cv::Affine3d(cv::Matx44d(matrix.data()));
}

Alignment align(const Pyramid& source, const Pyramid& target, const cv::Affine3d& guess,
                const AlignmentOptions& options) {
  if (options.term == AlignmentTerm::automatic) {
    AlignmentOptions one = options;
    one.term = AlignmentTerm::depth;
    Alignment byDepth = align(source, target, guess, one);
    if (byDepth.solved && byDepth.conditioning >= kMinConditioning) return byDepth;
    one.term = AlignmentTerm::hybrid;
    return align(source, target, guess, one);
  }
  Alignment alignment;
  alignment.solved = true;
  alignment.transform = guess;
  const std::size_t levels = std::min(source.size(), target.size());
  int steps = options.maxSteps;
  for (std::size_t level = levels; level-- > 0; steps = std::max(1, steps / 2))
    for (int i = 0; i < steps; ++i) {
      const AlignmentStep step =
          open3d().step(source[level], target[level], matrixOf(alignment.transform), options.term,
                        static_cast<float>(options.maxDifference * std::pow(2.0, level)));
      if (!step.solved) {
        alignment.solved = false;
        return alignment;
      }
      const cv::Affine3d correction = rigidOf(step.correction);
      alignment.transform = correction * alignment.transform;
      if (cv::norm(correction.translation()) < kConverged && angleOf(correction) < kConverged) break;
    }
  evaluate(alignment, source.front(), target.front(), options.sameSurface);
  return alignment;
}

}  // namespace estancia::odometry
