// Pictures and errors for the tests of io.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include "estancia/core/error.hpp"

namespace estancia::test {

/// The bytes of `picture` as a file with the suffix `suffix` (".png").
inline std::string encoded(const std::string& suffix, const cv::Mat& picture,
                           const std::vector<int>& options = {}) {
  std::vector<uchar> bytes;
  cv::imencode(suffix, picture, bytes, options);
  return {bytes.begin(), bytes.end()};
}

/// A picture with detail in it, so that its compressed data is long enough to be cut.
inline cv::Mat texture(int width, int height, int type = CV_8UC3) {
  cv::Mat picture(height, width, type);
  cv::RNG(7).fill(picture, cv::RNG::UNIFORM, 0, picture.depth() == CV_16U ? 65536 : 256);
  return picture;
}

inline cv::Mat plain(int width, int height, const cv::Scalar& bgr) {
  return {height, width, CV_8UC3, bgr};
}

/// Calls `work(0)` … `work(count - 1)` at the same time, each in a thread of its own.
template <typename Work>
void inThreads(int count, const Work& work) {
  std::vector<std::jthread> threads(static_cast<std::size_t>(count));
  for (int t = 0; t < count; ++t)
    threads[static_cast<std::size_t>(t)] = std::jthread([&work, t] { work(t); });
}

}  // namespace estancia::test
