// Matrix products: scalar products of all rows of one matrix with all rows of another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

/// Rows packed once for SIMD, to be multiplied with many others.
class PackedRows {
 public:
  explicit PackedRows(const DescriptorMatrix& rows);

  std::size_t size() const { return size_; }
  std::size_t labels() const { return labels_; }
  /// Panel p holds rows 32 p … 32 p + 31, label by label; rows beyond the last are 0.
  std::size_t panels() const { return (size_ + width - 1) / width; }
  const float* panel(std::size_t p) const {
    return reinterpret_cast<const float*>(values_.data()) + p * width * labels_;
  }

  static constexpr std::size_t width = 32;
  struct alignas(64) Line {
    float numbers[16];
  };

 private:
  std::size_t size_, labels_;
  std::vector<Line> values_;
};

/// Calls take(i, products) for each row i of `rows`, with row i · b for all rows b; from several threads,
/// each row once; the products are theirs to change. Float32 sums in the order of the labels: the numbers do
/// not depend on threads; their last bits do on whether the processor fuses multiplications and additions.
/// O(N M L). Throws Error when the rows are not equally long, Interrupted when the user asks to stop.
void rowProducts(const DescriptorMatrix& rows, const PackedRows& others, int threads,
                 const std::function<void(std::size_t, std::span<float>)>& take);

/// Σ of squares of each row.
std::vector<float> squaredNorms(const DescriptorMatrix& rows);

}  // namespace estancia
