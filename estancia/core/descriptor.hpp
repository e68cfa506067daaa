// Lexical descriptor: one probability per label (thesis Eq. 4.1), and matrices of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace estancia {

/// d(I) = [p_I(l_1) … p_I(l_L)]: L probabilities in [0, 1]. They need not add up to 1 (multi-label sources).
using LexicalDescriptor = std::vector<float>;

/// A read-only view of a descriptor, or of a row of a DescriptorMatrix.
using DescriptorView = std::span<const float>;

/// N descriptors over the same L labels, row-major N×L, contiguous.
class DescriptorMatrix {
 public:
  explicit DescriptorMatrix(std::size_t labels) : labels_(labels) {}

  std::size_t size() const { return labels_ == 0 ? 0 : values_.size() / labels_; }
  std::size_t labels() const { return labels_; }
  DescriptorView row(std::size_t i) const { return {values_.data() + i * labels_, labels_}; }
  const std::vector<float>& values() const { return values_; }
  void reserve(std::size_t rows) { values_.reserve(rows * labels_); }

  /// Appends one row. Throws Error (mismatch) when its length is not labels().
  void append(DescriptorView row);

 private:
  std::size_t labels_;
  std::vector<float> values_;
};

/// Throws Error (mismatch, labelerFailure) unless `descriptor` has `labels` values that are all finite and in
/// [0, 1] (up to rounding). `source` names its origin in the message.
void requireProbabilities(DescriptorView descriptor, std::size_t labels, const std::string& source);

}  // namespace estancia
