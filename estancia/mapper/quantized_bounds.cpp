// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/quantized_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

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

/// Query values as bytes above 0: the signed ones + 128. Processors with VNNI multiply such bytes with signed
/// ones and add four products at once. Four rows side by side hide how long that takes.
constexpr int byteOffset = 128;

#if ESTANCIA_HAS_TARGETS
__attribute__((target("avx512f,avx512bw,avx512vl,avx512vnni"))) void byteDotsVnni(const std::int8_t* rows,
                                                                                  std::size_t count,
                                                                                  std::size_t stride,
                                                                                  const std::uint8_t* query,
                                                                                  std::int32_t* dots) {
  std::size_t r = 0;
  for (; r + 4 <= count; r += 4) {
    const std::int8_t *a = rows + r * stride, *b = a + stride, *c = b + stride, *d = c + stride;
    std::int32_t toA = 0, toB = 0, toC = 0, toD = 0;
    for (std::size_t i = 0; i < stride; ++i) {
      toA += query[i] * a[i];
      toB += query[i] * b[i];
      toC += query[i] * c[i];
      toD += query[i] * d[i];
    }
    dots[r] = toA;
    dots[r + 1] = toB;
    dots[r + 2] = toC;
    dots[r + 3] = toD;
  }
  for (; r < count; ++r) {
    std::int32_t sum = 0;
    for (std::size_t i = 0; i < stride; ++i) sum += query[i] * rows[r * stride + i];
    dots[r] = sum;
  }
}

bool hasVnni() {
  return __builtin_cpu_supports("avx512vnni") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
         __builtin_cpu_supports("avx512vl") != 0;
}
#endif

constexpr std::size_t lanes = 16;  // sums of their own: a register of AVX-512

struct SquaredNorms {
  float rough = 0, error = 0;
};

/// Bytes of `length` values, and the norms of scale · bytes and of what they lack; summed in registers.
ESTANCIA_MULTIVERSION
SquaredNorms round(const float* values, std::size_t length, float scale, std::int8_t* bytes) {
  constexpr float nearest = 12582912;  // 1.5 · 2²³: adding it rounds to whole numbers
  const float inverse = 1 / scale;
  float rough[lanes] = {}, error[lanes] = {};
  const auto add = [&](std::size_t i, std::size_t lane) {
    const float whole = (values[i] * inverse + nearest) - nearest;
    const float kept = scale * whole, lacks = values[i] - kept;
    bytes[i] = static_cast<std::int8_t>(whole);
    rough[lane] += kept * kept;
    error[lane] += lacks * lacks;
  };
  std::size_t i = 0;
  for (; i + lanes <= length; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) add(i + lane, lane);
  for (std::size_t lane = 0; i < length; ++i, ++lane) add(i, lane);
  SquaredNorms sums;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    sums.rough += rough[lane];
    sums.error += error[lane];
  }
  return sums;
}

ESTANCIA_MULTIVERSION
float largestOf(const float* values, std::size_t length) {
  float largest[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= length; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane)
      largest[lane] =
          std::fabs(values[i + lane]) > largest[lane] ? std::fabs(values[i + lane]) : largest[lane];
  float all = 0;
  for (; i < length; ++i) all = std::max(all, std::fabs(values[i]));
  return std::max(all, *std::max_element(largest, largest + lanes));
}

}  // namespace

QuantizedUpperBounds::QuantizedUpperBounds(std::size_t length)
    : length_(length), stride_((length + cacheLine - 1) / cacheLine * cacheLine) {}

QuantizedUpperBounds::Row QuantizedUpperBounds::quantize(std::span<const float> vector,
                                                         std::int8_t* bytes) const {
  const float largest = largestOf(vector.data(), length_);
  // Where 1 / scale has no float, the vector is as good as none: its norm is its error.
  constexpr float least = 1e-30F;
  if (largest < least) {
    std::fill_n(bytes, length_, std::int8_t{0});
    return {1, 0, largest * std::sqrt(static_cast<float>(length_))};
  }
  const float scale = largest / 127;
  const SquaredNorms norms = round(vector.data(), length_, scale, bytes);
  return {scale, std::sqrt(norms.rough), std::sqrt(norms.error)};
}

void QuantizedUpperBounds::set(std::size_t slot, std::span<const float> vector) {
  if (slot == rows_.size()) {
    rows_.emplace_back();
    bytes_.resize(rows_.size() * stride_, 0);
  }
  std::int8_t* bytes = bytes_.data() + slot * stride_;
  rows_[slot] = quantize(vector, bytes);
  rows_[slot].sum = std::accumulate(bytes, bytes + stride_, std::int32_t{0});
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

void QuantizedUpperBounds::dotsWith(const std::vector<std::int8_t>& query,
                                    std::span<std::int32_t> dots) const {
#if ESTANCIA_HAS_TARGETS
  // Beyond, byteOffset · 127 · stride_ does not fit into 32 bits.
  if (static const bool has = hasVnni(); has && stride_ <= maxLength / 2) {
    std::vector<std::uint8_t> raised(stride_);
    std::ranges::transform(query, raised.begin(),
                           [](std::int8_t value) { return static_cast<std::uint8_t>(value + byteOffset); });
    byteDotsVnni(bytes_.data(), rows_.size(), stride_, raised.data(), dots.data());
    for (std::size_t i = 0; i < rows_.size(); ++i) dots[i] -= byteOffset * rows_[i].sum;
    return;
  }
#endif
  const std::vector<std::int16_t> wide(query.begin(), query.end());
  byteDots(bytes_.data(), rows_.size(), stride_, wide.data(), dots.data());
}

void QuantizedUpperBounds::upperBounds(std::span<const float> query, std::span<float> upper) const {
  std::vector<std::int8_t> rough(stride_, 0);
  const Row q = quantize(query, rough.data());
  std::vector<std::int32_t> dots(rows_.size());
  dotsWith(rough, dots);
  // a·b = â·b̂ + â·(b − b̂) + (a − â)·b  ≤  â·b̂ + ‖â‖‖b − b̂‖ + ‖a − â‖‖b‖, and ‖b‖ ≤ ‖b̂‖ + ‖b − b̂‖
  const float queryNorm = q.roughNorm + q.errorNorm;
  constexpr float rounding = 1e-6F;  // float32 rounding here and in the exact product
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const float slack = row.roughNorm * q.errorNorm + row.errorNorm * queryNorm;
    upper[i] = row.scale * q.scale * static_cast<float>(dots[i]) + slack +
               rounding * (row.roughNorm + row.errorNorm) * queryNorm * 8;
  }
}

}  // namespace estancia
