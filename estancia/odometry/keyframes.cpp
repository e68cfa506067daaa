// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/keyframes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"

namespace estancia::odometry {
namespace {

constexpr int kLevels = 3;
constexpr int kFeatures = 500;
constexpr double kMinDepthShare = 0.02;  // share of the pixels; below, alignment is unreliable
constexpr std::size_t kLatest = 8;       // keyframes among which a frame is tracked: they hardly drift apart
constexpr double kMinPrediction = 0.3;   // overlap; with less a keyframe helps little

}  // namespace

Choices alignmentTerms() {
  return {{"auto", "depth and color, as if these were registered to each other within pixels only"},
          {"depth", "point-to-plane distances; nothing holds along a bare wall"},
          {"color", "differences of gray values; needs texture"},
          {"hybrid", "depth and color; needs both exactly registered"}};
}

AlignmentTerm alignmentTerm(const std::string& name) {
  requireChoice("term of odometry", name, alignmentTerms());
  if (name == "depth") return AlignmentTerm::depth;
  if (name == "color") return AlignmentTerm::color;
  return name == "hybrid" ? AlignmentTerm::hybrid : AlignmentTerm::automatic;
}

std::unique_ptr<FrameView> viewOf(const Sequence& sequence, std::size_t frame, const RgbdOptions& options) {
  auto view = std::make_unique<FrameView>();
  view->frame = frame;
  try {
    const cv::Mat depth = sequence.depth(frame), bgr = sequence.image(frame);
    if (!sameShape(bgr.size(), depth.size()))
      fail(ErrorCode::mismatch,
           "depth has {} × {} pixels and the image {} × {}, so they show different views; export "
           "depth registered to color (see `estancia check`)",
           depth.cols, depth.rows, bgr.cols, bgr.rows);
    const CameraIntrinsics camera = sequence.intrinsics()->scaledTo(depth.cols, depth.rows);
    view->image = reducedImage(bgr, depth, camera, options.maxWidth, options.maxDepth);
    const int usable = cv::countNonZero(view->image.depth);
    if (usable < kMinDepthShare * static_cast<double>(view->image.depth.total())) {
      view->problem =
          fmt::format("{} of {} pixels have depth up to {} m (see --depth-scale and `estancia check`)",
                      usable, view->image.depth.total(), options.maxDepth);
    } else {
      view->pyramid = pyramidOf(view->image, kLevels);
      view->features = featuresOf(bgr, depth, view->image.camera, kFeatures, options.maxDepth);
    }
  } catch (...) {
    view->problem = frameFailure(sequence.frame(frame).name).what();
  }
  return view;
}

double predictedOverlap(const PyramidLevel& source, const PyramidLevel& target, const cv::Affine3d& motion) {
  const CameraIntrinsics& c = target.camera;
  std::size_t points = 0, same = 0;
  for (int y = 0; y < source.points.rows; ++y)
    for (int x = 0; x < source.points.cols; ++x) {
      const cv::Vec3f& point = source.points.at<cv::Vec3f>(y, x);
      if (!(point[2] > 0)) continue;
      ++points;
      const cv::Vec3d p = motion * cv::Vec3d(point);
      if (!(p[2] > 0)) continue;
      const double u = c.fx * p[0] / p[2] + c.cx, v = c.fy * p[1] / p[2] + c.cy;
      if (!(u >= 0 && v >= 0 && u < target.depth.cols - 1 && v < target.depth.rows - 1)) continue;
      const auto z = static_cast<double>(
          target.depth.at<float>(static_cast<int>(std::lround(v)), static_cast<int>(std::lround(u))));
      if (std::abs(z - p[2]) < 0.1 * p[2]) ++same;
    }
  return points == 0 ? 0 : static_cast<double>(same) / static_cast<double>(points);
}

Keyframes::Keyframes(const RgbdOptions& options, const FrameWords& words)
    : options_(options), words_(words), recall_(words.parts) {}

Pyramid Keyframes::newPyramid(std::size_t k) const {
  return pyramidOf(keyframes_[k].image, kLevels);
}

const Pyramid& Keyframes::pyramid(std::size_t k) const {
  const auto found = std::ranges::find_if(cached_, [&](const auto& cached) { return cached.first == k; });
  if (found != cached_.end()) {
    std::rotate(cached_.begin(), found, found + 1);
  } else {
    if (cached_.size() >= kLatest) cached_.pop_back();
    cached_.emplace(cached_.begin(), k, std::make_unique<const Pyramid>(newPyramid(k)));
  }
  return *cached_.front().second;
}

std::size_t Keyframes::add(const FrameView& view, const cv::Affine3d& pose) {
  keyframes_.push_back({view.frame, pose, view.image, view.pyramid.back(), view.features});
  recall_.add(words_.describe ? words_.describe(view.frame) : LexicalDescriptor());
  return keyframes_.size() - 1;
}

std::vector<std::size_t> Keyframes::around(const FrameView& view, const cv::Affine3d& pose,
                                           std::size_t max) const {
  std::vector<std::pair<double, std::size_t>> found;
  for (std::size_t k = size(); k-- > 0 && k + kLatest >= size();) {
    const double overlap =
        predictedOverlap(view.pyramid.back(), keyframes_[k].coarse, keyframes_[k].pose.inv() * pose);
    if (overlap >= kMinPrediction) found.emplace_back(-overlap, k);
  }
  std::ranges::sort(found);
  std::vector<std::size_t> keyframes;
  for (const auto& [overlap, k] : found)
    if (keyframes.size() < max) keyframes.push_back(k);
  return keyframes;
}

std::vector<std::size_t> Keyframes::withSimilarWords(const FrameView& view) const {
  if (!words_.describe) return {};
  return recall_.nearest(recall_.embed(words_.describe(view.frame)),
                         static_cast<std::size_t>(options_.loopCandidates), [](std::size_t) { return true; });
}

std::vector<std::size_t> Keyframes::withWordsOf(std::size_t k, std::size_t apart) const {
  return recall_.nearest(recall_.embedded(k), static_cast<std::size_t>(options_.loopCandidates),
                         [&](std::size_t o) { return o + apart <= k || k + apart <= o; });
}

}  // namespace estancia::odometry
