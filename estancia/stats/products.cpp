// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/products.hpp"

#include <algorithm>
#include <cstring>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/simd.hpp"
#include "estancia/stats/distance.hpp"

namespace estancia {
namespace {

constexpr std::size_t lanes = 16;  // one vector of AVX-512, two of AVX
constexpr std::size_t tall =
    6;  // rows of a tile: 12 (or 6) sums stay in registers and hide each other's latency
constexpr std::size_t block = 96;  // rows that stay in the cache while the panels pass; a multiple of `tall`
using Vector [[gnu::vector_size(lanes * sizeof(float))]] = float;

/// Products of `tall` rows with `vectors` × `lanes` columns of a panel; row r of them goes to out + r stride.
template <std::size_t vectors>
[[gnu::always_inline]] inline void tile(const float* rows, const float* panel, std::size_t labels, float* out,
                                        std::size_t stride) {
  Vector sums[tall][vectors] = {};
  for (std::size_t k = 0; k < labels; ++k) {
    const auto* columns = reinterpret_cast<const Vector*>(panel + k * PackedRows::width);
#pragma GCC unroll 6
    for (std::size_t r = 0; r < tall; ++r) {
      const Vector row = rows[r * labels + k] - Vector{};
#pragma GCC unroll 2
      for (std::size_t v = 0; v < vectors; ++v) sums[r][v] += row * columns[v];
    }
  }
  for (std::size_t r = 0; r < tall; ++r)
    for (std::size_t v = 0; v < vectors; ++v)
      *reinterpret_cast<Vector*>(out + r * stride + v * lanes) = sums[r][v];
}

ESTANCIA_MULTIVERSION
void wideTile(const float* rows, const float* panel, std::size_t labels, float* out, std::size_t stride) {
  tile<2>(rows, panel, labels, out, stride);
}

ESTANCIA_MULTIVERSION
void narrowTile(const float* rows, const float* panel, std::size_t labels, float* out, std::size_t stride) {
  tile<1>(rows, panel, labels, out, stride);
}

/// Whether 32 registers of 16 numbers are there; else a tile of half the width fits.
bool hasWideRegisters() {
#if defined(__x86_64__) && defined(__GNUC__)
  return __builtin_cpu_supports("avx512f") != 0;
#else
  return false;
#endif
}

}  // namespace

PackedRows::PackedRows(const DescriptorMatrix& rows) : size_(rows.size()), labels_(rows.labels()) {
  values_.resize(std::max<std::size_t>(panels() * width * labels_ / lanes, 1));
  for (std::size_t i = 0; i < size_; ++i) {
    float* column = values_.front().numbers + i / width * width * labels_ + i % width;
    for (const float value : rows.row(i)) {
      *column = value;
      column += width;
    }
  }
}

void rowProducts(const DescriptorMatrix& rows, const PackedRows& others, int threads,
                 const std::function<void(std::size_t, std::span<float>)>& take) {
  const std::size_t labels = rows.labels(), n = rows.size();
  if (labels != others.labels())
    fail(ErrorCode::mismatch, "rows have {} and {} numbers; give as many of each", labels, others.labels());
  static const bool wide = hasWideRegisters();
  const std::size_t stride = others.panels() * PackedRows::width;
  inParallel((n + block - 1) / block, threads, Progress::none(), "stopped while rows were multiplied",
             [&](std::size_t b) {
               const std::size_t begin = b * block, count = std::min(block, n - begin);
               const std::size_t padded = (count + tall - 1) / tall * tall;
               std::vector<float> strip(padded * labels);
               std::vector<PackedRows::Line> lines(padded * stride / lanes);
               float* const products = lines.empty() ? nullptr : lines.front().numbers;
               std::memcpy(strip.data(), rows.values().data() + begin * labels,
                           count * labels * sizeof(float));
               for (std::size_t p = 0; p < others.panels(); ++p)
                 for (std::size_t i = 0; i < padded; i += tall) {
                   const float *a = strip.data() + i * labels, *panel = others.panel(p);
                   float* out = products + i * stride + p * PackedRows::width;
                   if (wide) {
                     wideTile(a, panel, labels, out, stride);
                   } else {
                     narrowTile(a, panel, labels, out, stride);
                     narrowTile(a, panel + lanes, labels, out + lanes, stride);
                   }
                 }
               for (std::size_t i = 0; i < count; ++i)
                 take(begin + i, {products + i * stride, others.size()});
             });
}

std::vector<float> squaredNorms(const DescriptorMatrix& rows) {
  std::vector<float> norms(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) norms[i] = dot(rows.row(i), rows.row(i));
  return norms;
}

}  // namespace estancia
