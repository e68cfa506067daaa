// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/products.hpp"

#include <algorithm>
#include <cstring>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/simd.hpp"
#include "estancia/distances/distance.hpp"

namespace estancia {
namespace {

constexpr std::size_t tall = 6;    // rows of a tile: its 12 sums stay in registers, hide each other's latency
constexpr std::size_t block = 96;  // rows that stay in the cache while the panels pass; a multiple of `tall`
constexpr std::size_t line = sizeof(PackedRows::Line) / sizeof(float);

/// Products of `tall` rows with the columns of a panel; row r of them goes to out + r stride.
template <std::size_t lanes>
[[gnu::always_inline]] inline void multiply(const float* rows, const float* panel, std::size_t labels,
                                            float* out, std::size_t stride) {
  using Float = typename Simd<lanes>::Float;
  for (std::size_t first = 0; first < PackedRows::width; first += 2 * lanes) {
    Float sums[tall][2] = {};
    for (std::size_t k = 0; k < labels; ++k) {
      const auto* columns = reinterpret_cast<const Float*>(panel + k * PackedRows::width + first);
#pragma GCC unroll 6
      for (std::size_t r = 0; r < tall; ++r) {
        const Float row = rows[r * labels + k] - Float{};
        sums[r][0] += row * columns[0];
        sums[r][1] += row * columns[1];
      }
    }
    for (std::size_t r = 0; r < tall; ++r)
      for (std::size_t v = 0; v < 2; ++v)
        *reinterpret_cast<Float*>(out + r * stride + first + v * lanes) = sums[r][v];
  }
}

ESTANCIA_TARGET_16_LANES
void multiply16(const float* rows, const float* panel, std::size_t labels, float* out, std::size_t stride) {
  multiply<16>(rows, panel, labels, out, stride);
}

ESTANCIA_TARGET_8_LANES
void multiply8(const float* rows, const float* panel, std::size_t labels, float* out, std::size_t stride) {
  multiply<8>(rows, panel, labels, out, stride);
}

void multiply4(const float* rows, const float* panel, std::size_t labels, float* out, std::size_t stride) {
  multiply<4>(rows, panel, labels, out, stride);
}

}  // namespace

PackedRows::PackedRows(const DescriptorMatrix& rows) : size_(rows.size()), labels_(rows.labels()) {
  values_.resize(std::max<std::size_t>(panels() * width * labels_ / line, 1));
  for (std::size_t i = 0; i < size_; ++i) {
    float* column = reinterpret_cast<float*>(values_.data()) + i / width * width * labels_ + i % width;
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
  static const auto product = ofThisProcessor(multiply16, multiply8, multiply4);
  const std::size_t stride = others.panels() * PackedRows::width;
  inParallel((n + block - 1) / block, threads, Progress::none(), "stopped while rows were multiplied",
             [&](std::size_t b) {
               const std::size_t begin = b * block, count = std::min(block, n - begin);
               const std::size_t padded = (count + tall - 1) / tall * tall;
               std::vector<float> strip(padded * labels);
               std::vector<PackedRows::Line> lines(padded * stride / line);
               float* const products = reinterpret_cast<float*>(lines.data());
               std::memcpy(strip.data(), rows.values().data() + begin * labels,
                           count * labels * sizeof(float));
               for (std::size_t p = 0; p < others.panels(); ++p)
                 for (std::size_t i = 0; i < padded; i += tall)
                   product(strip.data() + i * labels, others.panel(p), labels,
                           products + i * stride + p * PackedRows::width, stride);
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
