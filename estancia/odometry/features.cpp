// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/features.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/odometry/packed_image.hpp"

namespace estancia::odometry {
namespace {

constexpr int kDescriptorBytes = 32;

cv::Point3f pointAt(const CameraIntrinsics& camera, const cv::Point2f& pixel, float z) {
  return {static_cast<float>(camera.slopeX(pixel.x)) * z, static_cast<float>(camera.slopeY(pixel.y)) * z, z};
}

}  // namespace

Features featuresOf(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera, int max,
                    double maxDepth) {
  Features features;
  features.camera = camera.scaledTo(bgr.cols, bgr.rows);
  cv::Mat gray, descriptors;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  std::vector<cv::KeyPoint> corners;
  cv::ORB::create(max, 1.2F, 8, 15, 0, 2, cv::ORB::HARRIS_SCORE, 15)
      ->detectAndCompute(gray, cv::noArray(), corners, descriptors);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const cv::Point2f& at = corners[i].pt;
    const int x = static_cast<int>(at.x * static_cast<float>(depth.cols) / static_cast<float>(bgr.cols));
    const int y = static_cast<int>(at.y * static_cast<float>(depth.rows) / static_cast<float>(bgr.rows));
    const float z = depth.at<float>(std::clamp(y, 0, depth.rows - 1), std::clamp(x, 0, depth.cols - 1));
    if (!(z > 0 && z <= maxDepth)) continue;
    features.pixels.push_back(at);
    features.points.push_back(pointAt(features.camera, at, z));
    features.descriptors.push_back(descriptors.row(static_cast<int>(i)));
  }
  return features;
}

void write(const Features& features, ByteWriter& bytes) {
  write(features.camera, bytes);
  bytes.number(static_cast<std::uint64_t>(features.pixels.size()));
  for (std::size_t i = 0; i < features.pixels.size(); ++i) {
    bytes.number(features.pixels[i].x), bytes.number(features.pixels[i].y);
    bytes.number(features.points[i].z);
    const auto* descriptor = features.descriptors.ptr<char>(static_cast<int>(i));
    bytes.raw({descriptor, kDescriptorBytes});
  }
}

Features readFeatures(ByteReader& bytes) {
  Features features;
  features.camera = readCamera(bytes);
  const std::size_t count = bytes.count(3 * sizeof(float) + kDescriptorBytes);
  features.descriptors.create(static_cast<int>(count), kDescriptorBytes, CV_8U);
  for (std::size_t i = 0; i < count; ++i) {
    const float u = bytes.number<float>(), v = bytes.number<float>(), z = bytes.number<float>();
    features.pixels.emplace_back(u, v);
    features.points.push_back(pointAt(features.camera, {u, v}, z));
    const std::string_view descriptor = bytes.raw(kDescriptorBytes);
    std::ranges::copy(descriptor, features.descriptors.ptr<char>(static_cast<int>(i)));
  }
  return features;
}

std::optional<cv::Affine3d> guessFromFeatures(const Features& source, const Features& target,
                                              int minInliers) {
  if (static_cast<int>(std::min(source.points.size(), target.points.size())) < minInliers)
    return std::nullopt;
  std::vector<cv::DMatch> matches;
  cv::BFMatcher(cv::NORM_HAMMING, /*crossCheck=*/true).match(source.descriptors, target.descriptors, matches);
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
  constexpr float kMaxDistance = 64;  // of 256 bits: beyond, ORB matches are mostly chance
  for (const cv::DMatch& match : matches) {
    if (match.distance > kMaxDistance) continue;
    points.push_back(source.points[static_cast<std::size_t>(match.queryIdx)]);
    pixels.push_back(target.pixels[static_cast<std::size_t>(match.trainIdx)]);
  }
  if (static_cast<int>(points.size()) < minInliers) return std::nullopt;
  const CameraIntrinsics& c = target.camera;
  const cv::Matx33d camera(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  cv::Vec3d rotation, translation;
  std::vector<int> inliers;
  const auto tolerance =
      static_cast<float>(0.01 * c.width);  // [pixels]; depth and color may be a little apart
  try {
    if (!cv::solvePnPRansac(points, pixels, camera, cv::noArray(), rotation, translation, false, 300,
                            tolerance, 0.99, inliers, cv::SOLVEPNP_AP3P))
      return std::nullopt;
  } catch (const cv::Exception&) {  // degenerate points
    return std::nullopt;
  }
  if (static_cast<int>(inliers.size()) < minInliers || !std::isfinite(cv::norm(rotation)) ||
      !std::isfinite(cv::norm(translation)))
    return std::nullopt;
  return cv::Affine3d(rotation, translation);
}

}  // namespace estancia::odometry
