#include "estancia/check/reprojection.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace estancia::check {
namespace {

constexpr int kWidth = 160;          // of the small depth image [pixels]
constexpr int kStride = 4;           // from point to point in it [pixels]
constexpr double kTolerance = 0.04;  // of the depth: noise, and pixels that do not coincide

std::size_t matching(const DepthView& from, const DepthView& to, const cv::Affine3d& toFromFrom) {
  std::size_t count = 0;
  for (const cv::Vec3d& point : from.points()) {
    const cv::Vec3d moved = toFromFrom * point;
    if (std::abs(to.depthTowards(moved) - moved[2]) < kTolerance * moved[2]) ++count;
  }
  return count;
}

}  // namespace

DepthView::DepthView(const cv::Mat& depth, const CameraIntrinsics& camera) {
  const int width = std::min(kWidth, depth.cols), height = std::max(1, depth.rows * width / depth.cols);
  cv::resize(depth, depth_, {width, height}, 0, 0, cv::INTER_NEAREST);  // depths must not be interpolated
  camera_ = camera.scaledTo(width, height);
  for (int v = kStride / 2; v < height; v += kStride)
    for (int u = kStride / 2; u < width; u += kStride)
      if (const double z = depth_.at<float>(v, u); z > 0)
        points_.emplace_back(camera_.slopeX(u) * z, camera_.slopeY(v) * z, z);
}

double DepthView::depthTowards(const cv::Vec3d& p) const {
  if (!(p[2] > 0)) return 0;
  const double u = camera_.fx * p[0] / p[2] + camera_.cx + 0.5,
               v = camera_.fy * p[1] / p[2] + camera_.cy + 0.5;
  if (!(u >= 0 && v >= 0 && u < depth_.cols && v < depth_.rows)) return 0;
  return depth_.at<float>(static_cast<int>(v), static_cast<int>(u));
}

double reprojectionMatch(const DepthView& a, const DepthView& b, const cv::Affine3d& bFromA) {
  const std::size_t total = a.points().size() + b.points().size();
  if (total == 0) return 0;
  return static_cast<double>(matching(a, b, bFromA) + matching(b, a, bFromA.inv())) /
         static_cast<double>(total);
}

}  // namespace estancia::check
