// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/quantized_bounds.hpp"

#include <algorithm>
#include <cmath>

#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::size_t cacheLine = 64;

ESTANCIA_MULTIVERSION
void byteDots(const std::int8_t* rows, std::size_t count, std::size_t stride, const std::int16_t* query,
              std::int32_t* dots) {
  for (std::size_t r = 0; r < count; ++r) {
    const std::int8_t* row = rows + r * stride;
    std::int32_t sum =
        0;  // 127² · maxLength fits; a plain loop, since the compiler knows the pairwise multiply-add
    for (std::size_t i = 0; i < stride; ++i) sum += static_cast<std::int16_t>(row[i]) * query[i];
    dots[r] = sum;
  }
}

}  // namespace

QuantizedUpperBounds::QuantizedUpperBounds(std::size_t length)
    : length_(length), stride_((length + cacheLine - 1) / cacheLine * cacheLine) {}

QuantizedUpperBounds::Row QuantizedUpperBounds::quantize(std::span<const float> vector,
                                                         std::int8_t* bytes) const {
  float largest = 0;
  for (const float v : vector) largest = std::max(largest, std::fabs(v));
  const float scale = largest > 0 ? largest / 127 : 1;
  double rough = 0, error = 0;
  for (std::size_t i = 0; i < length_; ++i) {
    bytes[i] = static_cast<std::int8_t>(std::lrintf(vector[i] / scale));
    const double kept = static_cast<double>(scale) * bytes[i];
    rough += kept * kept;
    error += (vector[i] - kept) * (vector[i] - kept);
  }
  return {scale, static_cast<float>(std::sqrt(rough)), static_cast<float>(std::sqrt(error))};
}

void QuantizedUpperBounds::set(std::size_t slot, std::span<const float> vector) {
  if (slot == rows_.size()) {
    rows_.emplace_back();
    bytes_.resize(rows_.size() * stride_, 0);
  }
  rows_[slot] = quantize(vector, bytes_.data() + slot * stride_);
}

void QuantizedUpperBounds::remove(std::size_t slot) {
  const std::size_t last = rows_.size() - 1;
  if (slot != last) {
    rows_[slot] = rows_[last];
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(last * stride_), stride_,
                bytes_.begin() + static_cast<std::ptrdiff_t>(slot * stride_));
  }
  rows_.pop_back();
  bytes_.resize(rows_.size() * stride_);
}

void QuantizedUpperBounds::upperBounds(std::span<const float> query, std::span<float> upper) const {
  std::vector<std::int8_t> rough(stride_, 0);
  const Row q = quantize(query, rough.data());
  const std::vector<std::int16_t> wide(rough.begin(), rough.end());
  std::vector<std::int32_t> dots(rows_.size());
  byteDots(bytes_.data(), rows_.size(), stride_, wide.data(), dots.data());
  // a·b = â·b̂ + â·(b − b̂) + (a − â)·b  ≤  â·b̂ + ‖â‖‖b − b̂‖ + ‖a − â‖‖b‖, and ‖b‖ ≤ ‖b̂‖ + ‖b − b̂‖
  const float queryNorm = q.roughNorm + q.errorNorm;
  constexpr float rounding = 1e-6F;  // of the float32 arithmetic here and in the exact product
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const float slack = row.roughNorm * q.errorNorm + row.errorNorm * queryNorm;
    upper[i] = row.scale * q.scale * static_cast<float>(dots[i]) + slack +
               rounding * (row.roughNorm + row.errorNorm) * queryNorm * 8;
  }
}

}  // namespace estancia
