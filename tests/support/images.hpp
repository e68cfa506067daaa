// Images, warnings and threads for the tests of io.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include "estancia/core/error.hpp"

namespace estancia::test {

/// The bytes of `image` as a file with the suffix `suffix` (".png").
inline std::string encoded(const std::string& suffix, const cv::Mat& image,
                           const std::vector<int>& options = {}) {
  std::vector<uchar> bytes;
  cv::imencode(suffix, image, bytes, options);
  return {bytes.begin(), bytes.end()};
}

/// An image with detail in it, so that its compressed data is long enough to be cut.
inline cv::Mat texture(int width, int height, int type = CV_8UC3) {
  cv::Mat image(height, width, type);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, image.depth() == CV_16U ? 65536 : 256);
  return image;
}

inline cv::Mat plain(int width, int height, const cv::Scalar& bgr) {
  return {height, width, CV_8UC3, bgr};
}

/// Expects equal size, type and pixels.
inline void expectSame(const cv::Mat& a, const cv::Mat& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.type(), b.type());
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
}

/// Matches a sentence that names each of `facts`: counts, file names and other values of the input, never
/// prose.
MATCHER_P(MentionsAll, facts, "") {
  for (const std::string& fact : facts)
    if (std::string(arg).find(fact) == std::string::npos) {
      *result_listener << "without \"" << fact << "\"";
      return false;
    }
  return true;
}
inline auto Mentions(const std::vector<std::string>& facts) {
  return MentionsAll(facts);
}

/// Calls `work(0)` … `work(count - 1)` at the same time, each in a thread of its own.
template <typename Work>
void inThreads(int count, const Work& work) {
  std::vector<std::jthread> threads(static_cast<std::size_t>(count));
  for (int t = 0; t < count; ++t)
    threads[static_cast<std::size_t>(t)] = std::jthread([&work, t] { work(t); });
}

}  // namespace estancia::test
