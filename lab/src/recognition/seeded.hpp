// Seeded numbers: random numbers that are equal on every machine.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <opencv2/core/matx.hpp>
#include <random>
#include <vector>

namespace estancia::experiments {

class Seeded {
 public:
  explicit Seeded(std::uint64_t seed) : bits_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11U) * 0x1p-53;
  }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(bits_() % count); }
  cv::Vec3d direction() {
    const double z = between(-1, 1), turn = between(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
  /// Standard normal (Box and Muller).
  double normal() {
    return std::sqrt(-2 * std::log(1 - between(0, 1))) * std::cos(2 * std::numbers::pi * between(0, 1));
  }

 private:
  std::mt19937_64 bits_;
};

/// Directions that are spread evenly over the sphere (Fibonacci's lattice).
inline std::vector<cv::Vec3d> directionsAround(std::size_t count) {
  std::vector<cv::Vec3d> all(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double turn = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    all[i] = {r * std::cos(turn), r * std::sin(turn), z};
  }
  return all;
}

}  // namespace estancia::experiments
