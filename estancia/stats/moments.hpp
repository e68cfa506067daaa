// Running moments: mean and variance of descriptors in float32, accurate over millions of images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace estancia {

/// Weighted mean and population variance of a stream of vectors (Welford 1962, West 1979; thesis
/// Eq. 4.3, 4.4). The mean carries its rounding error (Kahan), so that the 10⁶th image still changes it.
class Moments {
 public:
  /// `spread`: also the variance.
  Moments(std::size_t labels, bool spread);

  /// Adds one vector with weight > 0, or removes weight (< 0) of a vector added before. Throws Error
  /// (invalidState) when more weight is removed than there is.
  void add(std::span<const float> x, double weight = 1);

  /// Adds all vectors of `other` (Chan et al. 1979).
  void merge(const Moments& other);

  /// Removes the vectors of `other`, which were added before; for means only. What is left of no weight is 0.
  void remove(const Moments& other);

  double weight() const { return weight_; }
  std::span<const float> mean() const { return mean_; }
  /// Empty without spread.
  std::span<const float> variance() const { return variance_; }

  /// For the map file, and back. Throws Error (corruptFile) unless toBytes() wrote them for so many labels.
  std::string toBytes() const;
  static Moments fromBytes(std::string_view bytes, std::size_t labels, bool spread);
  static std::size_t byteCount(std::size_t labels, bool spread);

 private:
  double weight_ = 0;
  std::vector<float> mean_, carry_, variance_;
};

}  // namespace estancia
