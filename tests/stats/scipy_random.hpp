// Random numbers that the scripts make, too, whose results the tests compare with (scipy_random.py).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace estancia::test {

/// A linear congruential generator that both sides have (Knuth's MMIX).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// A multiple of 2^-24 in [0, 1).
  double uniform() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 40) / 0x1p24;
  }

 private:
  std::uint64_t state_;
};

}  // namespace estancia::test
