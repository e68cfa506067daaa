// Made-up objects on a table, seen by a depth camera that moves around them: ray casting, no noise.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::test {

const inline cv::Vec3b red{0, 0, 255}, blue{255, 0, 0};  // BGR

struct Solid {
  enum class Kind { ball, box };
  Kind kind = Kind::ball;
  cv::Vec3d center;  ///< on the map, whose z = 0 is the table [m]
  cv::Vec3d half;    ///< half of its extents; a ball's radius is the first [m]
  cv::Vec3b bgr;
};

/// A ball or a box that stands on the table.
Solid ballAt(double x, double y, double radius, const cv::Vec3b& bgr);
Solid boxAt(double x, double y, const cv::Vec3d& half, const cv::Vec3b& bgr);

/// 320 × 240 pixels; frames are called "0000.png" …
class TableSequence : public Sequence {
 public:
  /// One frame for each of `degrees` around the middle of the table, seen from 0.9 m away and above. Without
  /// `table` the objects float in nothing.
  TableSequence(const std::vector<Solid>& solids, const std::vector<double>& degrees, bool table = true);

  std::string name() const override { return "table"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  cv::Mat image(std::size_t i) const override { return seen_.at(i).first; }
  bool hasDepth() const override { return depth_; }
  /// Throws Error where it was lost.
  cv::Mat depth(std::size_t i) const override;

  void loseDepth(std::size_t i) { seen_.at(i).second.release(); }
  void loseAllDepth() { depth_ = false; }
  void loseCamera() { intrinsics_.reset(); }
  void losePoses();
  /// Multiplies all images.
  void dim(double factor);

  /// Writes rgb/, depth/ (millimeters), intrinsics.txt and poses.txt, which openSequence() reads.
  void writeTo(const std::filesystem::path& folder) const;

 private:
  std::vector<Frame> frames_;
  std::vector<std::pair<cv::Mat, cv::Mat>> seen_;
  bool depth_ = true;
};

}  // namespace estancia::test
