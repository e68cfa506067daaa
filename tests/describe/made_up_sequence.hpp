// A sequence in memory: images, and depth where it is given.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::test {

class MadeUpSequence final : public Sequence {
 public:
  /// An empty image cannot be read; an empty depth is missing.
  void add(cv::Mat image, cv::Mat depth = {}) {
    Frame frame;
    frame.name = fmt::format("{:04}.png", frames_.size());
    frame.room = frames_.size() % 2 == 0 ? "kitchen" : "office";
    frames_.push_back(frame);
    hasDepth_ = hasDepth_ || !depth.empty();
    images_.push_back(std::move(image));
    depths_.push_back(std::move(depth));
  }
  void setCamera(const CameraIntrinsics& camera) { intrinsics_ = camera; }

  std::string name() const override { return "made up"; }
  std::size_t size() const override { return frames_.size(); }
  const Frame& frame(std::size_t i) const override { return frames_[i]; }
  cv::Mat image(std::size_t i) const override {
    if (images_[i].empty()) throw Error(ErrorCode::fileUnreadable, "cannot be read");
    return images_[i];
  }
  bool hasDepth() const override { return hasDepth_; }
  cv::Mat depth(std::size_t i) const override {
    if (depths_[i].empty()) throw Error(ErrorCode::fileUnreadable, "no depth image");
    return depths_[i];
  }

 private:
  std::vector<Frame> frames_;
  std::vector<cv::Mat> images_, depths_;
  bool hasDepth_ = false;
};

/// Noise of blocks: edges of every direction.
inline cv::Mat busyImage(cv::Size size, unsigned seed, int channels = 3) {
  cv::Mat blocks(std::max(1, size.height / 8), std::max(1, size.width / 8), CV_8UC(channels)), image;
  cv::RNG(seed).fill(blocks, cv::RNG::UNIFORM, 0, 256);
  cv::resize(blocks, image, size, 0, 0, cv::INTER_CUBIC);
  return image;
}

}  // namespace estancia::test
