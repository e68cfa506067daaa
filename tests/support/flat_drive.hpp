// A drive through a made-up flat of two rooms and a corridor, by a camera with depth.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "support/floor_scene.hpp"

namespace estancia::test {

/// Turns once around in the left room, the corridor and the right room; each has a word of its own.
class FlatDrive : public Sequence {
 public:
  explicit FlatDrive(double tilt = -0.1) {
    intrinsics_ = smallCamera();
    const double stops[][2] = {{2, 2}, {2.5, 5.2}, {6.5, 5.2}, {7, 2}};
    const char* rooms[] = {"bedroom", "corridor", "corridor", "kitchen"};
    for (int stop = 0; stop < 4; ++stop)
      for (int i = 0; i < 16; ++i) {
        Frame frame;
        frame.name = "frame " + std::to_string(frames_.size());
        frame.pose = lookingAt(stops[stop][0], stops[stop][1], 1, i * std::numbers::pi / 8, tilt);
        frame.room = rooms[stop];
        frames_.push_back(frame);
      }
  }

  std::string name() const override { return "flat"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_.at(i); }
  cv::Mat image(std::size_t) const override { return {48, 64, CV_8UC3, cv::Scalar()}; }
  bool hasDepth() const override { return true; }
  cv::Mat depth(std::size_t i) const override {
    if (dark(i)) throw Error(ErrorCode::fileUnreadable, frames_[i].name + ": no depth");
    return zero(i) ? cv::Mat(48, 64, CV_32F, cv::Scalar(0)) : flatDepth(*frames_[i].pose);
  }

  DescriptorSequence labeled() const {
    DescriptorSequence result{Vocabulary({"bed", "stove", "doormat", "wall"}), "test", frames_,
                              DescriptorMatrix(4)};
    for (const Frame& frame : frames_) {
      LexicalDescriptor words{0.05F, 0.05F, 0.05F, 0.3F};
      words[frame.room == "bedroom" ? 0 : frame.room == "kitchen" ? 1 : 2] = 0.6F;
      result.descriptors.append(words);
    }
    return result;
  }

  /// The drive labeled by English words that indicate its rooms.
  DescriptorSequence labeledInWords() const {
    DescriptorSequence result{Vocabulary({"four-poster", "quilt", "pillow", "stove", "refrigerator",
                                          "dishwasher", "doormat", "wall"}),
                              "test", frames_, DescriptorMatrix(8)};
    for (const Frame& frame : frames_) {
      LexicalDescriptor words(8, 0.02F);
      const std::size_t first = frame.room == "bedroom" ? 0 : frame.room == "kitchen" ? 3 : 6;
      for (std::size_t l = first; l < std::min<std::size_t>(first + 3, 8); ++l) words[l] = 0.28F;
      result.descriptors.append(words);
    }
    return result;
  }

  std::function<bool(std::size_t)> dark = [](std::size_t) { return false; }, zero = dark;
  std::vector<Frame> frames_;
};

}  // namespace estancia::test
