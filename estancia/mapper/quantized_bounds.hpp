// Quantized upper bounds: 8-bit vectors rule out most candidates of an exact nearest-neighbor search.
// Private. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace estancia {

/// Holds vectors quantized to 8 bits, and the exact norms of their rounding errors. Bounds dot products with
/// a query from above (Cauchy–Schwarz on the errors), at a quarter of the memory traffic of float32.
class QuantizedUpperBounds {
 public:
  explicit QuantizedUpperBounds(std::size_t length);

  /// Longer dot products could overflow 32 bits.
  static constexpr std::size_t maxLength = 100'000;

  /// Sets vector `slot`, appending when slot = size().
  void set(std::size_t slot, std::span<const float> vector);
  /// Removes `slot`; the last vector takes its place.
  void remove(std::size_t slot);
  std::size_t size() const { return rows_.size(); }

  /// upper[i] ≥ dot(vector i, query), for all i; `upper` has size() values.
  void upperBounds(std::span<const float> query, std::span<float> upper) const;

 private:
  struct Row {
    float scale;           ///< value ≈ scale · byte
    float roughNorm;       ///< ‖scale · bytes‖
    float errorNorm;       ///< ‖value − scale · bytes‖
    std::int32_t sum = 0;  ///< sum of the bytes
  };
  /// Dot products of the query's bytes with each row.
  void dotsWith(const std::vector<std::int8_t>& query, std::span<std::int32_t> dots) const;
  Row quantize(std::span<const float> vector, std::int8_t* bytes) const;

  std::size_t length_;
  std::size_t stride_;  ///< length_ rounded up to whole cache lines
  std::vector<std::int8_t> bytes_;
  std::vector<Row> rows_;
};

}  // namespace estancia
