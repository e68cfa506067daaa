// Keyframes: the images of the pose graph, its edges, and loop closure between them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/choice.hpp"
#include "estancia/odometry/alignment.hpp"
#include "estancia/odometry/features.hpp"
#include "estancia/odometry/recall.hpp"
#include "estancia/odometry/rgbd.hpp"

namespace estancia::odometry {

/// The names of AlignmentTerm: auto, depth, color, hybrid.
Choices alignmentTerms();
/// Throws Error (unknownName).
AlignmentTerm alignmentTerm(const std::string& name);

/// One frame, ready to be aligned.
struct FrameView {
  std::size_t frame = 0;
  std::string problem;  ///< why it cannot be aligned; "" when it can
  RgbdImage image;
  Pyramid pyramid;
  cv::Mat bgr, depth;  ///< as read
};

/// Reports what is wrong with a frame in FrameView::problem instead of throwing.
std::unique_ptr<FrameView> viewOf(const Sequence& sequence, std::size_t frame, const RgbdOptions& options);

class Keyframes {
 public:
  Keyframes(const RgbdOptions& options, const FrameWords& words);

  std::size_t size() const { return keyframes_.size(); }
  std::size_t frame(std::size_t k) const { return keyframes_[k].frame; }
  const cv::Affine3d& pose(std::size_t k) const { return keyframes_[k].pose; }
  const AlignmentOptions& alignment() const { return alignment_; }

  /// Computed from the stored image; the latest two are cached.
  const Pyramid& pyramid(std::size_t k) const;

  /// Returns its number.
  std::size_t add(const FrameView& view, const cv::Affine3d& pose);

  /// The camera was tracked from one to the other: `alignment` is T_to_from.
  void connect(std::size_t from, std::size_t to, const Alignment& alignment);

  /// T_keyframe_view by features alone.
  std::optional<cv::Affine3d> guess(const FrameView& view, std::size_t k) const;

  /// The keyframes with the most similar words.
  std::vector<std::size_t> withSimilarWords(const FrameView& view) const;

  /// Proposes loop closures by words and verifies them.
  void closeLoops(Progress& progress);

  /// Pose graph optimization: moves the keyframes. Returns the accepted loop closures.
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
  mutable std::vector<std::pair<std::size_t, Pyramid>> cached_;  ///< used by the tracking thread alone
};

}  // namespace estancia::odometry
