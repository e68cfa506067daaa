// Map poses: the poses of keyframes as reported last; small corrections are not reported.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <vector>

#include "estancia/odometry/keyframe_graph.hpp"

namespace estancia::odometry {

/// The optimum of the pose graph moves by fractions of a millimeter with every keyframe. Who fuses what was
/// seen at a pose need not do it again for that.
class MapPoses {
 public:
  /// T_map_keyframe; nothing for keyframes that are not in the map, the part with the most frames.
  const std::optional<cv::Affine3d>& at(std::size_t k) const { return told_[k]; }
  std::uint64_t revision() const { return revision_; }
  /// Whether both keyframes belong to one part, as of the last update.
  bool areJoined(std::size_t a, std::size_t b) const { return part_[a] == part_[b]; }

  /// How many frames belong to its part, as of the last update.
  std::size_t framesOfPartOf(std::size_t k) const { return partFrames_[part_[k]]; }

  /// Counts frames that depend on keyframe k.
  void count(std::size_t k, std::ptrdiff_t frames);
  /// Whether another part than the map has the most frames now.
  bool isOutgrown() const { return outgrown_; }

  /// Reports the poses of new keyframes; and the optimum of all when it moves what an earlier one shows by
  /// more than `tolerance` [m], or other keyframes belong to the map.
  void update(const Keyframes& keyframes, const KeyframeGraph& graph, double tolerance);
  void removeLast();

  void write(ByteWriter& bytes) const;
  /// Takes the place of update() and of count(). Throws Error (malformedFile).
  void read(const KeyframeGraph& graph, std::vector<std::size_t> framesOf, ByteReader& bytes);

 private:
  void countParts(const KeyframeGraph& graph, std::size_t keyframes);

  std::vector<std::optional<cv::Affine3d>> told_;
  std::uint64_t revision_ = 0;
  std::size_t map_ = 0;  ///< the part that was reported
  bool outgrown_ = false;
  std::vector<std::size_t> frames_;      ///< frame of each keyframe
  std::vector<std::size_t> part_;        ///< part of each keyframe, as of the last update
  std::vector<std::size_t> partFrames_;  ///< by the part's number
};

}  // namespace estancia::odometry
