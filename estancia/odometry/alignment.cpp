#include "estancia/odometry/alignment.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/core/rigid.hpp"

namespace estancia::odometry {
namespace {

constexpr double kSettled = 1e-4;  // [m] and [rad]: a step that changes less is the last on its level

/// Looks where every point of the source falls in the target: how well the two agree, and what that fixes.
void judge(Alignment& alignment, const PyramidLevel& source, const PyramidLevel& target, double sameSurface) {
  std::size_t points = 0, seen = 0, same = 0;
  double squares = 0;
  const CameraIntrinsics& c = target.camera;
  cv::Matx66d information = cv::Matx66d::zeros();
  for (int y = 0; y < source.points.rows; ++y)
    for (int x = 0; x < source.points.cols; ++x) {
      const cv::Vec3f point = source.points.at<cv::Vec3f>(y, x);
      if (!(point[2] > 0)) continue;
      ++points;
      const cv::Vec3d p = alignment.transform * cv::Vec3d(point);
      if (!(p[2] > 0)) continue;
      const double u = c.fx * p[0] / p[2] + c.cx, v = c.fy * p[1] / p[2] + c.cy;
      if (!(u >= 0 && v >= 0 && u <= c.width - 1 && v <= c.height - 1)) continue;
      const float z =
          target.depth.at<float>(static_cast<int>(std::lround(v)), static_cast<int>(std::lround(u)));
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
  Alignment alignment;
  alignment.solved = true;
  alignment.transform = guess;
  const std::size_t levels = std::min(source.size(), target.size());
  int steps = options.mostSteps;
  for (std::size_t level = levels; level-- > 0; steps = std::max(1, steps / 2))
    for (int i = 0; i < steps; ++i) {
      const AlignmentStep step = open3d().step(source[level], target[level], matrixOf(alignment.transform),
                                               options.term, static_cast<float>(options.beyond));
      if (!step.solved) {
        alignment.solved = false;
        return alignment;
      }
      const cv::Affine3d correction = rigidOf(step.correction);
      alignment.transform = correction * alignment.transform;
      if (cv::norm(correction.translation()) < kSettled && angleOf(correction) < kSettled) break;
    }
  judge(alignment, source.front(), target.front(), options.sameSurface);
  return alignment;
}

}  // namespace estancia::odometry
