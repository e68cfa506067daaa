// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/undistortion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/printable.hpp"

namespace estancia::io {
namespace {

constexpr double maxOfView = 50 * std::numbers::pi / 180;  // to either side
constexpr std::uint32_t maxCameraPixels = 1 << 14;         // wide or high

/// One calibrated camera in OpenCV's terms.
struct Calibration {
  cv::Matx33d matrix;
  cv::Mat distortion;
  bool isFisheye = false;

  std::vector<cv::Point2d> undistorted(const std::vector<cv::Point2d>& pixels) const {
    std::vector<cv::Point2d> slopes;
    if (isFisheye)
      cv::fisheye::undistortPoints(pixels, slopes, matrix, distortion);
    else
      cv::undistortPoints(pixels, slopes, matrix, distortion);
    return slopes;
  }
};

/// The slope of the nearer of two border pixels, at most the limit, which it is also without a ray.
double slopeSeen(double one, double other) {
  const double limit = std::tan(maxOfView);
  const double slope = std::min(std::abs(one), std::abs(other));
  return std::isfinite(slope) && slope > 0 ? std::min(slope, limit) : limit;
}

CameraIntrinsics pinholeFor(const Calibration& from, int width, int height) {
  const double right = width - 1, bottom = height - 1;
  const auto slopes = from.undistorted({{0, from.matrix(1, 2)},
                                        {right, from.matrix(1, 2)},
                                        {from.matrix(0, 2), 0},
                                        {from.matrix(0, 2), bottom}});
  // Pixels stay square: the axis that sees less for its size decides.
  const double focal = std::max(right / 2 / slopeSeen(slopes[0].x, slopes[1].x),
                                bottom / 2 / slopeSeen(slopes[2].y, slopes[3].y));
  return {width, height, focal, focal, right / 2, bottom / 2};
}

void requireCalibration(const ros::CameraInfo& info, double fx, double fy) {
  const auto isFinite = [](double n) { return std::isfinite(n) && std::abs(n) < 1e9; };
  if (info.width == 0 || info.height == 0 || info.width > maxCameraPixels || info.height > maxCameraPixels)
    fail(ErrorCode::invalidInput, "the camera info announces images of {} × {} pixels", info.width,
         info.height);
  if (!std::ranges::all_of(info.matrix, isFinite) || !std::ranges::all_of(info.projection, isFinite) ||
      !std::ranges::all_of(info.distortion, isFinite))
    fail(ErrorCode::invalidInput, "the camera info holds numbers that are not finite");
  if (!(fx > 0 && fy > 0))
    fail(ErrorCode::invalidInput,
         "the camera info has a focal length of {} × {}: the camera is not calibrated", fx, fy);
}

/// Truncated to the number of coefficients that OpenCV takes.
cv::Mat coefficients(const ros::CameraInfo& info, bool isFisheye) {
  const std::size_t given = info.distortion.size();
  const std::size_t wanted = isFisheye     ? 4
                             : given <= 4  ? 4
                             : given <= 5  ? 5
                             : given <= 8  ? 8
                             : given <= 12 ? 12
                                           : 14;
  if (given > 14) fail(ErrorCode::invalidInput, "the camera info has {} distortion coefficients", given);
  cv::Mat numbers = cv::Mat::zeros(static_cast<int>(wanted), 1, CV_64F);
  for (std::size_t i = 0; i < std::min(given, wanted); ++i)
    numbers.at<double>(static_cast<int>(i)) = info.distortion[i];
  return numbers;
}

}  // namespace

Undistortion::Undistortion(const ros::CameraInfo& info, bool isRectified) {
  const auto& k = info.matrix;
  const auto& p = info.projection;
  const bool byProjection = isRectified && p[0] > 0;
  requireCalibration(info, byProjection ? p[0] : k[0], byProjection ? p[5] : k[4]);
  const int width = static_cast<int>(info.width), height = static_cast<int>(info.height);
  camera_ = byProjection ? CameraIntrinsics{width, height, p[0], p[5], p[2], p[6]}
                         : CameraIntrinsics{width, height, k[0], k[4], k[2], k[5]};
  if (isRectified || std::ranges::all_of(info.distortion, [](double d) { return d == 0; })) return;
  const std::string& model = info.distortionModel;
  const bool isFisheye = model == "equidistant" || model == "fisheye" || model == "kannala_brandt";
  if (!isFisheye && model != "plumb_bob" && model != "rational_polynomial" && !model.empty())
    fail(ErrorCode::unsupportedFile,
         "the distortion model \"{}\" is not read; it can be plumb_bob, rational_polynomial or equidistant",
         printable(model));
  const Calibration calibration{
      {k[0], k[1], k[2], k[3], k[4], k[5], k[6], k[7], k[8]}, coefficients(info, isFisheye), isFisheye};
  camera_ = pinholeFor(calibration, width, height);
  const cv::Matx33d to(camera_.fx, 0, camera_.cx, 0, camera_.fy, camera_.cy, 0, 0, 1);
  const cv::Size size(width, height);
  if (isFisheye)
    cv::fisheye::initUndistortRectifyMap(calibration.matrix, calibration.distortion, cv::noArray(), to, size,
                                         CV_32FC1, mapX_, mapY_);
  else
    cv::initUndistortRectifyMap(calibration.matrix, calibration.distortion, cv::noArray(), to, size, CV_32FC1,
                                mapX_, mapY_);
}

cv::Mat Undistortion::mapped(const cv::Mat& image, int interpolation) const {
  if (!isNeeded()) return image;
  cv::Mat result;
  if (image.cols == camera_.width && image.rows == camera_.height) {
    cv::remap(image, result, mapX_, mapY_, interpolation, cv::BORDER_CONSTANT);
    return result;
  }
  // Images of another size: the maps are scaled.
  const double sx = static_cast<double>(image.cols) / camera_.width,
               sy = static_cast<double>(image.rows) / camera_.height;
  cv::Mat x, y;
  cv::resize(mapX_, x, image.size(), 0, 0, cv::INTER_LINEAR);
  cv::resize(mapY_, y, image.size(), 0, 0, cv::INTER_LINEAR);
  x = (x + 0.5) * sx - 0.5;
  y = (y + 0.5) * sy - 0.5;
  cv::remap(image, result, x, y, interpolation, cv::BORDER_CONSTANT);
  return result;
}

cv::Mat Undistortion::image(const cv::Mat& image) const {
  return mapped(image, cv::INTER_LINEAR);
}

cv::Mat Undistortion::depth(const cv::Mat& depth) const {
  return mapped(depth, cv::INTER_NEAREST);
}

cv::Mat registerDepth(const cv::Mat& depth, const CameraIntrinsics& from, const cv::Affine3d& toFromFrom,
                      const CameraIntrinsics& to) {
  requireDepth(depth, from);
  const CameraIntrinsics source = from.scaledTo(depth.cols, depth.rows),
                         target = to.scaledTo(depth.cols, depth.rows);
  const cv::Matx33d rotation = toFromFrom.rotation();
  const cv::Vec3d shift = toFromFrom.translation();
  cv::Mat registered = cv::Mat::zeros(depth.size(), CV_32F);
  for (int row = 0; row < depth.rows; ++row)
    for (int column = 0; column < depth.cols; ++column) {
      const double z = static_cast<double>(depth.at<float>(row, column));
      if (!(z > 0 && std::isfinite(z))) continue;
      const cv::Vec3d seen =
          rotation * cv::Vec3d(z * source.slopeX(column), z * source.slopeY(row), z) + shift;
      if (!(seen[2] > 0)) continue;
      const double u = std::round(target.fx * seen[0] / seen[2] + target.cx);
      const double v = std::round(target.fy * seen[1] / seen[2] + target.cy);
      if (!(u >= 0 && v >= 0 && u < depth.cols && v < depth.rows)) continue;
      float& nearest = registered.at<float>(static_cast<int>(v), static_cast<int>(u));
      if (nearest == 0 || seen[2] < static_cast<double>(nearest)) nearest = static_cast<float>(seen[2]);
    }
  return registered;
}

}  // namespace estancia::io
