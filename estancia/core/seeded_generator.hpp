// Reproducible runs of OpenCV's algorithms that draw random numbers.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace estancia {

/// OpenCV draws from a generator that belongs to the thread: seeded here, given back as it was.
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
