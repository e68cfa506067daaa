// Keyframes: the images among which a camera is tracked, and between which loops are closed.
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
  Features features;
};

/// Reports what is wrong with a frame in FrameView::problem instead of throwing.
std::unique_ptr<FrameView> viewOf(const Sequence& sequence, std::size_t frame, const RgbdOptions& options);

struct Keyframe {
  std::size_t frame;
  cv::Affine3d pose;  ///< T_map_keyframe
  RgbdImage image;
  PyramidLevel coarse;  ///< the coarsest level of its pyramid
  Features features;
};

/// Share of the source's points that lie on the target's surface at this T_target_source, within a tenth of
/// their depth. Takes coarse levels.
double predictedOverlap(const PyramidLevel& source, const PyramidLevel& target, const cv::Affine3d& motion);

class Keyframes {
 public:
  Keyframes(const RgbdOptions& options, const FrameWords& words);

  std::size_t size() const { return keyframes_.size(); }
  const Keyframe& operator[](std::size_t k) const { return keyframes_[k]; }
  const cv::Affine3d& pose(std::size_t k) const { return keyframes_[k].pose; }
  void move(std::size_t k, const cv::Affine3d& pose) { keyframes_[k].pose = pose; }

  /// Computed from the stored image; the latest few are cached, for the tracking thread alone.
  const Pyramid& pyramid(std::size_t k) const;
  /// The same, not cached: for any thread.
  Pyramid newPyramid(std::size_t k) const;

  /// Returns its number.
  std::size_t add(const FrameView& view, const cv::Affine3d& pose);

  /// At most `max` of the latest keyframes that a view at `pose` (T_map_view) overlaps, the most first.
  std::vector<std::size_t> around(const FrameView& view, const cv::Affine3d& pose, std::size_t max) const;

  /// The keyframes with the most similar words.
  std::vector<std::size_t> withSimilarWords(const FrameView& view) const;
  /// The same for keyframe k, of those at least `apart` keyframes from it.
  std::vector<std::size_t> withWordsOf(std::size_t k, std::size_t apart) const;

 private:
  const RgbdOptions& options_;
  const FrameWords& words_;
  std::vector<Keyframe> keyframes_;
  Recall recall_;
  mutable std::vector<std::pair<std::size_t, std::unique_ptr<const Pyramid>>> cached_;
};

}  // namespace estancia::odometry
