// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/frame_view.hpp"

#include <fmt/format.h>

#include <cmath>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/pose.hpp"

namespace estancia::odometry {
namespace {

constexpr int pyramidLevels = 3;
constexpr int maxFeatures = 500;
constexpr double minDepthShare = 0.02;  // share of the pixels; below, alignment is unreliable

void requireSameView(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera) {
  if (bgr.empty() || bgr.type() != CV_8UC3)
    fail(ErrorCode::invalidInput, "the image is empty, or not BGR of 8 bits; convert it");
  if (depth.empty() || depth.type() != CV_32F)
    fail(ErrorCode::invalidInput, "the depth is empty, or not in meters (CV_32F); convert it");
  if (!sameShape(bgr.size(), depth.size()))
    fail(ErrorCode::mismatch,
         "depth has {} × {} pixels and the image {} × {}, so they show different views; export depth "
         "registered to color (see `estancia check`)",
         depth.cols, depth.rows, bgr.cols, bgr.rows);
  if (!sameShape(depth.size(), {camera.width, camera.height}))
    fail(ErrorCode::mismatch,
         "depth has {} × {} pixels and the camera {} × {}; give the intrinsics of these images", depth.cols,
         depth.rows, camera.width, camera.height);
}

}  // namespace

Pyramid pyramidOf(const PackedImage& image) {
  return pyramidOf(unpacked(image), pyramidLevels);
}

FrameView viewOf(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera,
                 const RgbdOptions& options, const std::string& name) {
  FrameView view;
  try {
    requireSameView(bgr, depth, camera);
    const CameraIntrinsics scaled = camera.scaledTo(depth.cols, depth.rows);
    view.image =
        packed(reducedImage(bgr, depth, scaled, options.maxWidth, options.maxDepth), options.maxDepth);
    const int usable = cv::countNonZero(view.image.depth);
    if (usable < minDepthShare * static_cast<double>(view.image.depth.total()))
      fail(ErrorCode::insufficientData,
           "{} of {} pixels have depth up to {} m (see --depth-scale and `estancia check`)", usable,
           view.image.depth.total(), options.maxDepth);
    view.pyramid = pyramidOf(view.image);
    view.features = featuresOf(bgr, depth, scaled, maxFeatures, options.maxDepth);
  } catch (...) {
    view.problem = frameFailure(name).what();
  }
  return view;
}

CoarseView coarseOf(const Pyramid& pyramid) {
  const cv::Mat& depth = pyramid.back().depth;
  return {pyramid.back().camera, depth, cv::mean(depth, depth > 0)[0]};
}

double shiftOfScene(const cv::Affine3d& motion, const CoarseView& seen) {
  return cv::norm(motion.translation()) + angleOf(motion) * seen.meanDepth;
}

double predictedOverlap(const CoarseView& source, const CoarseView& target, const cv::Affine3d& motion,
                        int stride) {
  const CameraIntrinsics &from = source.camera, &c = target.camera;
  std::size_t points = 0, same = 0;
  for (int y = stride / 2; y < source.depth.rows; y += stride)
    for (int x = stride / 2; x < source.depth.cols; x += stride) {
      const auto depth = static_cast<double>(source.depth.at<float>(y, x));
      if (!(depth > 0)) continue;
      ++points;
      const cv::Vec3d p = motion * cv::Vec3d(from.slopeX(x) * depth, from.slopeY(y) * depth, depth);
      if (!(p[2] > 0)) continue;
      const double u = c.fx * p[0] / p[2] + c.cx, v = c.fy * p[1] / p[2] + c.cy;
      if (!(u >= 0 && v >= 0 && u < target.depth.cols - 1 && v < target.depth.rows - 1)) continue;
      const auto z = static_cast<double>(
          target.depth.at<float>(static_cast<int>(std::lround(v)), static_cast<int>(std::lround(u))));
      if (std::abs(z - p[2]) < 0.1 * p[2]) ++same;
    }
  return points == 0 ? 0 : static_cast<double>(same) / static_cast<double>(points);
}

}  // namespace estancia::odometry
