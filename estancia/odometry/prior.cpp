// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/prior.hpp"

#include <cmath>
#include <numbers>

#include "estancia/core/rigid.hpp"

namespace estancia::odometry {

std::optional<Motion> priorMotion(const MotionPrior& prior, std::size_t from, std::size_t to,
                                  const RgbdOptions& options) {
  if (to >= prior.size() || from >= to || !prior[from] || !prior[to]) return std::nullopt;
  constexpr double kLeastShift = 1e-3;  // [m] a step
  const double turn = options.odomTurn * std::numbers::pi / 180, share = options.odomShift / 100;
  const cv::Affine3d back = rigidOf(*prior[from]).inv();
  cv::Matx66d covariance = cv::Matx66d::zeros();
  std::size_t last = from;
  for (std::size_t i = from + 1; i <= to; ++i) {
    if (!prior[i]) continue;
    // A wrong turn at `last` swings what follows about it; it is written at `from`.
    const cv::Vec3d pivot = (back * rigidOf(*prior[last])).translation();
    const auto steps = static_cast<double>(i - last);
    const double shift = share * distanceBetween(*prior[last], *prior[i]);
    const double entries[] = {1, 0,         0,        0,        1, 0,         0,         0,        1,
                              0, -pivot[2], pivot[1], pivot[2], 0, -pivot[0], -pivot[1], pivot[0], 0};
    const cv::Matx<double, 6, 3> turned(entries);
    covariance += steps * turn * turn * turned * turned.t();
    for (int a = 3; a < 6; ++a) covariance(a, a) += shift * shift + steps * kLeastShift * kLeastShift;
    last = i;
  }
  return Motion{back * rigidOf(*prior[to]), covariance};
}

}  // namespace estancia::odometry
