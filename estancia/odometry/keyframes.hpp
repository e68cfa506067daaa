// The images that odometry keeps, what ties them together, and which of them see the same place.
#pragma once

#include <memory>
#include <mutex>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/odometry/alignment.hpp"
#include "estancia/odometry/features.hpp"
#include "estancia/odometry/recall.hpp"
#include "estancia/odometry/rgbd.hpp"

namespace estancia::odometry {

/// Throws Error listing the known names.
AlignmentTerm alignmentTerm(const std::string& name);

/// One frame, ready to be aligned.
struct FrameView {
  std::size_t frame = 0;
  std::string problem;  ///< why it cannot be; "" when all is well
  RgbdImage image;
  Pyramid pyramid;
  cv::Mat bgr, depth;  ///< as read
};

/// Never throws for what is wrong with one frame: see FrameView::problem.
std::unique_ptr<FrameView> viewOf(const Sequence& sequence, std::size_t frame, const RgbdOptions& options);

class Keyframes {
 public:
  Keyframes(const RgbdOptions& options, const FrameWords& words);

  std::size_t size() const { return keyframes_.size(); }
  std::size_t frame(std::size_t k) const { return keyframes_[k].frame; }
  const cv::Affine3d& pose(std::size_t k) const { return keyframes_[k].pose; }
  const AlignmentOptions& alignment() const { return alignment_; }

  /// Made from the kept image, the latest two at hand.
  const Pyramid& pyramid(std::size_t k) const;

  /// Returns its number.
  std::size_t add(const FrameView& view, const cv::Affine3d& pose);

  /// The camera was tracked from one to the other: `alignment` is T_to_from.
  void connect(std::size_t from, std::size_t to, const Alignment& alignment);

  /// T_keyframe_view by features alone.
  std::optional<cv::Affine3d> guess(const FrameView& view, std::size_t k) const;

  /// The keyframes whose words are nearest to the view's.
  std::vector<std::size_t> sayingTheSame(const FrameView& view) const;

  /// Finds and verifies pairs of keyframes that see the same place.
  void closeLoops(Progress& progress);

  /// Moves the keyframes to where all connections agree best. Returns the loops that were believed.
  std::vector<std::pair<std::size_t, std::size_t>> optimize();

 private:
  struct Keyframe {
    std::size_t frame;
    cv::Affine3d pose;
    RgbdImage image;
    Features features;
  };
  std::optional<PoseGraphEdge> verified(std::size_t source, std::size_t target) const;
  Features featuresOf(const FrameView& view) const;

  const RgbdOptions& options_;
  const FrameWords& words_;
  AlignmentOptions alignment_;
  std::vector<Keyframe> keyframes_;
  std::vector<PoseGraphEdge> edges_;
  Recall recall_;
  mutable std::vector<std::pair<std::size_t, Pyramid>> atHand_;  ///< used by the tracking thread alone
};

}  // namespace estancia::odometry
