// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/frame_view.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/simd.hpp"

namespace estancia::odometry {
namespace {

constexpr int descriptorBytes = 32;

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

cv::Point3f pointAt(const CameraIntrinsics& camera, const cv::Point2f& pixel, float z) {
  return {static_cast<float>(camera.slopeX(pixel.x)) * z, static_cast<float>(camera.slopeY(pixel.y)) * z, z};
}

/// Features with depth up to `maxDepth` [m]; `depth` [m, CV_32F] shows the same view in any size, `camera` is
/// scaled to both.
Features featuresOf(const cv::Mat& bgr, const cv::Mat& depth, const CameraIntrinsics& camera,
                    double maxDepth) {
  Features features;
  features.camera = camera.scaledTo(bgr.cols, bgr.rows);
  cv::Mat gray, descriptors;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  std::vector<cv::KeyPoint> corners;
  cv::ORB::create(500, 1.2F, 8, 15, 0, 2, cv::ORB::HARRIS_SCORE, 15)
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

struct Match {
  std::size_t source, target;
};

/// The nearest row of `others` for every row, and how many of its 256 bits differ; a row each of 4 words.
struct Nearest {
  std::size_t row = 0;
  int bits = 257;
};
ESTANCIA_MULTIVERSION
void findNearest(const std::uint64_t* rows, std::size_t count, const std::uint64_t* others,
                 std::size_t otherCount, Nearest* nearest, Nearest* nearestOfOthers) {
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < otherCount; ++j) {
      int bits = 0;
      for (std::size_t w = 0; w < 4; ++w) bits += std::popcount(rows[4 * i + w] ^ others[4 * j + w]);
      if (bits < nearest[i].bits) nearest[i] = {j, bits};
      if (bits < nearestOfOthers[j].bits) nearestOfOthers[j] = {i, bits};
    }
}

std::vector<std::uint64_t> wordsOf(const cv::Mat& descriptors) {
  std::vector<std::uint64_t> words(4 * static_cast<std::size_t>(descriptors.rows));
  for (int i = 0; i < descriptors.rows; ++i)
    std::memcpy(&words[static_cast<std::size_t>(4 * i)], descriptors.ptr(i), descriptorBytes);
  return words;
}

/// Features that are each other's nearest.
std::vector<Match> mutualMatches(const Features& source, const Features& target) {
  const auto from = wordsOf(source.descriptors), to = wordsOf(target.descriptors);
  std::vector<Nearest> nearest(source.points.size()), nearestOfTarget(target.points.size());
  findNearest(from.data(), nearest.size(), to.data(), nearestOfTarget.size(), nearest.data(),
              nearestOfTarget.data());
  std::vector<Match> matches;
  for (std::size_t i = 0; i < nearest.size(); ++i)
    if (nearest[i].bits <= 64 &&  // beyond, ORB matches are mostly chance
        nearestOfTarget[nearest[i].row].row == i)
      matches.push_back({i, nearest[i].row});
  return matches;
}

/// Matches whose distances to at least `least` others are equal in both views, as they are after any rigid
/// motion (Howard 2008); what chance matched is mostly gone before a motion is sought.
std::vector<Match> consistent(std::vector<Match> matches, const Features& source, const Features& target,
                              std::size_t least) {
  const auto areConsistent = [&](const Match& a, const Match& b) {
    const cv::Point3f &p = source.points[a.source], &q = source.points[b.source],
                      &r = target.points[a.target], &s = target.points[b.target];
    const double before = cv::norm(p - q), after = cv::norm(r - s);
    // 3 % of the depth of each point: some pixels to the side, and its noise.
    return std::abs(before - after) <= 0.03F * (std::max(p.z, r.z) + std::max(q.z, s.z));
  };
  for (std::size_t before = 0; before != matches.size() && matches.size() >= least;) {
    before = matches.size();
    std::vector<std::size_t> partners(before, 1);
    for (std::size_t i = 0; i < before; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (areConsistent(matches[i], matches[j])) ++partners[i], ++partners[j];
    std::vector<Match> kept;
    for (std::size_t i = 0; i < before; ++i)
      if (partners[i] >= least) kept.push_back(matches[i]);
    matches = std::move(kept);
  }
  return matches;
}

}  // namespace

Pyramid pyramidOf(const PackedImage& image) {
  return pyramidOf(unpacked(image), 3);
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
    if (usable < 0.02 * static_cast<double>(view.image.depth.total()))  // alignment would be unreliable
      fail(ErrorCode::insufficientData,
           "{} of {} pixels have depth up to {} m (see --depth-scale and `estancia check`)", usable,
           view.image.depth.total(), options.maxDepth);
    view.pyramid = pyramidOf(view.image);
    view.features = featuresOf(bgr, depth, scaled, options.maxDepth);
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

void write(const Features& features, ByteWriter& bytes) {
  write(features.camera, bytes);
  bytes.number(static_cast<std::uint64_t>(features.pixels.size()));
  for (std::size_t i = 0; i < features.pixels.size(); ++i) {
    bytes.number(features.pixels[i].x), bytes.number(features.pixels[i].y);
    bytes.number(features.points[i].z);
    const auto* descriptor = features.descriptors.ptr<char>(static_cast<int>(i));
    bytes.raw({descriptor, descriptorBytes});
  }
}

Features readFeatures(ByteReader& bytes) {
  Features features;
  features.camera = readCamera(bytes);
  const std::size_t count = bytes.count(3 * sizeof(float) + descriptorBytes);
  features.descriptors.create(static_cast<int>(count), descriptorBytes, CV_8U);
  for (std::size_t i = 0; i < count; ++i) {
    const float u = bytes.number<float>(), v = bytes.number<float>(), z = bytes.number<float>();
    features.pixels.emplace_back(u, v);
    features.points.push_back(pointAt(features.camera, {u, v}, z));
    const std::string_view descriptor = bytes.raw(descriptorBytes);
    std::ranges::copy(descriptor, features.descriptors.ptr<char>(static_cast<int>(i)));
  }
  return features;
}

std::optional<cv::Affine3d> guessFromFeatures(const Features& source, const Features& target,
                                              int minInliers) {
  const auto least = static_cast<std::size_t>(minInliers);
  if (std::min(source.points.size(), target.points.size()) < least) return std::nullopt;
  const std::vector<Match> matches = consistent(mutualMatches(source, target), source, target, least);
  if (matches.size() < least) return std::nullopt;
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
  for (const Match& match : matches) {
    points.push_back(source.points[match.source]);
    pixels.push_back(target.pixels[match.target]);
  }
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
