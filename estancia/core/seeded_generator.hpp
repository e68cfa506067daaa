// Seeded random numbers: makes OpenCV's random algorithms reproducible.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace estancia {

/// Seeds OpenCV's generator of this thread, and restores it on destruction.
class SeededGenerator {
 public:
  explicit SeededGenerator(std::uint64_t seed) : before_(cv::theRNG()) { cv::theRNG() = cv::RNG(seed); }
  ~SeededGenerator() { cv::theRNG() = before_; }
  SeededGenerator(const SeededGenerator&) = delete;
  SeededGenerator& operator=(const SeededGenerator&) = delete;

 private:
  cv::RNG before_;
};

}  // namespace estancia
