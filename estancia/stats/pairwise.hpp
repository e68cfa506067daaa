// The distances of all pairs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/stats/distance.hpp"

namespace estancia {

/// A symmetric matrix of n×n distances with a zero diagonal, condensed as SciPy's pdist gives it: d(0, 1),
/// d(0, 2) … d(0, n−1), d(1, 2) … Float64, since linkage averages in place: 8 · n (n − 1) / 2 bytes.
class CondensedDistances {
 public:
  /// Not yet filled in. Throws Error when there is no such memory.
  explicit CondensedDistances(std::size_t items);

  static std::uint64_t bytes(std::size_t items);

  std::size_t items() const { return items_; }
  std::span<double> values() & { return {values_.get(), size_}; }
  std::span<const double> values() const& { return {values_.get(), size_}; }
  std::span<const double> values() const&& = delete;  // they would be gone with it
  /// Distance of two different items.
  double operator()(std::size_t i, std::size_t j) const { return values_[i < j ? place(i, j) : place(j, i)]; }
  /// Distances of item i to i+1 … n−1.
  double* after(std::size_t i) { return values_.get() + (i + 1 < items_ ? place(i, i + 1) : size_); }

 private:
  std::size_t place(std::size_t i, std::size_t j) const { return i * (2 * items_ - i - 1) / 2 + j - i - 1; }
  struct Free {
    void operator()(double* values) const;
  };
  std::size_t items_, size_;
  std::unique_ptr<double[], Free> values_;
};

struct PairwiseOptions {
  int threads = 0;               ///< 0: as many as there are cores to use; changes nothing but the time
  Progress* progress = nullptr;  ///< told of rows done
};

/// compare(comparison, …) of all pairs of rows (see comparedVectors()), in float32, rounding apart: equal
/// rows are at exactly 0, none is negative. O(N² L). Throws Error when a value is not finite, Interrupted
/// when the user asks to stop.
CondensedDistances pairwiseDistances(const DescriptorMatrix& rows, Comparison comparison,
                                     const PairwiseOptions& options = {});

}  // namespace estancia
