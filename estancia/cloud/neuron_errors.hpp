// Neuron errors: accumulated errors with a common decay in O(1) and a fast maximum.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace estancia {

/// Errors only grow between insertions, so the maximum of a block of neurons is updated by the winners alone.
/// Decays are multiplied into one scale for all.
class NeuronErrors {
 public:
  double at(std::uint32_t i) const { return values_[i]; }
  void add(std::uint32_t i, double error) {
    values_[i] += error * inverse_;
    double& max = blocks_[i / block];
    max = std::max(max, values_[i]);
  }
  void prefetch(std::uint32_t i) const { __builtin_prefetch(values_.data() + i, 1); }
  void append(double value) {
    values_.push_back(value);
    if (blocks_.size() * block < values_.size()) blocks_.push_back(0);
    refresh(values_.size() - 1);
  }
  void set(std::uint32_t i, double value) {
    values_[i] = value;
    refresh(i);
  }
  /// The last one takes the number of the removed one.
  void remove(std::uint32_t i) {
    values_[i] = values_.back();
    values_.pop_back();
    refresh(i);
    refresh(values_.size());
    blocks_.resize((values_.size() + block - 1) / block);
  }
  /// The lowest number among equal errors.
  std::uint32_t largest() const {
    const auto b =
        static_cast<std::size_t>(std::max_element(blocks_.begin(), blocks_.end()) - blocks_.begin());
    const auto begin = values_.begin() + static_cast<std::ptrdiff_t>(b * block);
    const auto end = values_.begin() + static_cast<std::ptrdiff_t>(std::min(values_.size(), (b + 1) * block));
    return static_cast<std::uint32_t>(std::max_element(begin, end) - values_.begin());
  }
  void decayAll(double factor) {
    scale_ *= factor;
    inverse_ = 1 / scale_;
    if (scale_ > 1e-100) return;
    for (double& v : values_) v *= scale_;
    for (double& v : blocks_) v *= scale_;
    scale_ = inverse_ = 1;
  }

 private:
  static constexpr std::size_t block = 32;
  void refresh(std::size_t i) {
    const std::size_t b = i / block;
    double max = 0;
    for (std::size_t k = b * block; k < std::min(values_.size(), (b + 1) * block); ++k)
      max = std::max(max, values_[k]);
    blocks_[b] = max;
  }
  std::vector<double> values_, blocks_;
  double scale_ = 1, inverse_ = 1;
};

}  // namespace estancia
