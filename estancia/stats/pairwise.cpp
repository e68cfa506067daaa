// Distances of all pairs of rows, tile by tile (linkage.hpp).
// SPDX-License-Identifier: Apache-2.0

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/simd.hpp"
#include "estancia/stats/linkage.hpp"

namespace estancia {
namespace {

constexpr std::size_t tileColumns = 16;  // columns of a tile: one vector of AVX-512, two of AVX
constexpr std::size_t tileRows = 4;      // rows of a tile: their sums stay in registers
constexpr std::size_t blockRows = 64;    // rows that stay in the cache while the columns pass

/// One label of `tileColumns` rows.
struct alignas(tileColumns * sizeof(float)) Column {
  float values[tileColumns];
};

enum class Sum { squares, magnitudes, largest };

template <std::size_t lanes, Sum kind>
[[gnu::always_inline]] inline void add(typename Simd<lanes>::Float& sum,
                                       const typename Simd<lanes>::Float& difference) {
  using Float = typename Simd<lanes>::Float;
  if constexpr (kind == Sum::squares) {
    sum += difference * difference;
  } else {
    const auto magnitude = (Float)((typename Simd<lanes>::Bits)difference & 0x7FFFFFFF);
    if constexpr (kind == Sum::magnitudes)
      sum += magnitude;
    else
      sum = magnitude > sum ? magnitude : sum;
  }
}

/// Sums over the labels of `tileRows` rows (each `labels` long, one after the other) with `tileColumns`
/// columns that are packed label by label.
template <std::size_t lanes, Sum kind>
[[gnu::always_inline]] inline void tile(const float* rows, const Column* columns, std::size_t labels,
                                        float* out) {
  using Float = typename Simd<lanes>::Float;
  constexpr std::size_t vectors = lanes < 16 ? 2 : 1;
  for (std::size_t first = 0; first < tileColumns; first += vectors * lanes) {
    Float sums[tileRows][vectors] = {};
    for (std::size_t k = 0; k < labels; ++k) {
      const auto* column = reinterpret_cast<const Float*>(columns[k].values + first);
#pragma GCC unroll 4
      for (std::size_t r = 0; r < tileRows; ++r) {
        const Float row = rows[r * labels + k] - Float{};
#pragma GCC unroll 2
        for (std::size_t v = 0; v < vectors; ++v) add<lanes, kind>(sums[r][v], row - column[v]);
      }
    }
    for (std::size_t r = 0; r < tileRows; ++r)
      for (std::size_t c = 0; c < vectors * lanes; ++c)
        out[r * tileColumns + first + c] = sums[r][c / lanes][c % lanes];
  }
}

template <std::size_t lanes>
[[gnu::always_inline]] inline void tileOf(Sum kind, const float* rows, const Column* columns,
                                          std::size_t labels, float* out) {
  switch (kind) {
    case Sum::squares:
      return tile<lanes, Sum::squares>(rows, columns, labels, out);
    case Sum::magnitudes:
      return tile<lanes, Sum::magnitudes>(rows, columns, labels, out);
    case Sum::largest:
      return tile<lanes, Sum::largest>(rows, columns, labels, out);
  }
}

ESTANCIA_TARGET_16_LANES
void tile16(Sum kind, const float* rows, const Column* columns, std::size_t labels, float* out) {
  tileOf<16>(kind, rows, columns, labels, out);
}

ESTANCIA_TARGET_8_LANES
void tile8(Sum kind, const float* rows, const Column* columns, std::size_t labels, float* out) {
  tileOf<8>(kind, rows, columns, labels, out);
}

void tile4(Sum kind, const float* rows, const Column* columns, std::size_t labels, float* out) {
  tileOf<4>(kind, rows, columns, labels, out);
}

/// The sum that a comparison is; those with a logarithm or division a label gain nothing from tiles.
bool isTiled(Comparison comparison, Sum& kind) {
  switch (comparison) {
    case Comparison::meanSquare:
    case Comparison::rootMeanSquare:
    case Comparison::euclidean:
    case Comparison::cosine:
      kind = Sum::squares;
      return true;
    case Comparison::l1:
      kind = Sum::magnitudes;
      return true;
    case Comparison::chebyshev:
      kind = Sum::largest;
      return true;
    case Comparison::chiSquared:
    case Comparison::bhattacharyya:
    case Comparison::kullbackLeibler:
    case Comparison::jensenShannon:
      return false;
  }
  throw Error(ErrorCode::invalidOption, "the comparison is none of Comparison; give one of its values");
}

/// The rows twice, padded with zeros: one after the other, and in groups of `tileColumns` label by label.
/// Angles are those of unit vectors, whose squared difference is 2 (1 − cos): nothing cancels in small ones.
class Packed {
 public:
  Packed(const DescriptorMatrix& matrix, bool toUnit)
      : labels_(matrix.labels()), items_((matrix.size() + tileColumns - 1) / tileColumns * tileColumns) {
    rows_.resize(items_ * labels_);
    columns_.resize(items_ * labels_ / tileColumns);
    isZero_.resize(items_);
    for (std::size_t i = 0; i < matrix.size(); ++i) {
      const DescriptorView row = matrix.row(i);
      double squares = 0;
      for (const float value : row) squares += static_cast<double>(value) * value;
      isZero_[i] = squares > 0 ? 0 : 1;
      const double scale = toUnit && squares > 0 ? 1 / std::sqrt(squares) : 1;
      for (std::size_t k = 0; k < labels_; ++k)
        columns_[i / tileColumns * labels_ + k].values[i % tileColumns] = rows_[i * labels_ + k] =
            static_cast<float>(scale * row[k]);
    }
  }
  const float* row(std::size_t i) const { return rows_.data() + i * labels_; }
  const Column* columns(std::size_t first) const { return columns_.data() + first / tileColumns * labels_; }
  bool isZero(std::size_t i) const { return isZero_[i] != 0; }
  std::size_t labels() const { return labels_; }

 private:
  std::size_t labels_, items_;
  std::vector<float> rows_;
  std::vector<Column> columns_;
  std::vector<char> isZero_;
};

double finish(Comparison comparison, double sum, const Packed& packed, std::size_t i, std::size_t j) {
  const auto labels = static_cast<double>(packed.labels());
  switch (comparison) {
    case Comparison::meanSquare:
      return sum / labels;
    case Comparison::rootMeanSquare:
      return std::sqrt(sum / labels);
    case Comparison::euclidean:
      return std::sqrt(sum);
    case Comparison::cosine:
      // Zero vectors have no direction: equal among themselves only.
      if (packed.isZero(i) || packed.isZero(j)) return packed.isZero(i) == packed.isZero(j) ? 0 : 1;
      return std::min(sum / 2, 2.0);
    default:
      return sum;
  }
}

void requireFinite(const DescriptorMatrix& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const float value : rows.row(i))
      if (!std::isfinite(value))
        fail(ErrorCode::invalidInput, "descriptor {} holds {}; label its image again", i, value);
}

}  // namespace

CondensedDistances::CondensedDistances(std::size_t items) : items_(items), size_(items * (items - 1) / 2) {
  constexpr std::size_t page = std::size_t{2} << 20;
  if (items < 2) size_ = 0;
  const std::uint64_t whole = (bytes(items) + page - 1) / page * page;
  void* memory = items <= (std::size_t{1} << 30)
                     ? std::aligned_alloc(page, std::max<std::uint64_t>(whole, page))
                     : nullptr;
  if (memory == nullptr)
    fail(ErrorCode::tooLarge,
         "no memory for the distances of {} items ({:.1f} GiB); use fewer images, or the streaming "
         "mode (estancia zones find --stream)",
         items, static_cast<double>(bytes(items)) / (1 << 30));
#ifdef MADV_HUGEPAGE
  madvise(memory, whole, MADV_HUGEPAGE);  // columns are read across all pages
#endif
  values_.reset(static_cast<double*>(memory));
}

std::uint64_t CondensedDistances::bytes(std::size_t items) {
  const std::uint64_t n = items;
  if (n < 2) return 0;
  // Beyond 2³⁰ the product would overflow.
  return n > std::uint64_t{1} << 30 ? ~std::uint64_t{0} : n * (n - 1) / 2 * sizeof(double);
}

CondensedDistances pairwiseDistances(const DescriptorMatrix& rows, Comparison comparison, int threads,
                                     Progress& progress) {
  requireFinite(rows);
  const std::size_t n = rows.size(), labels = rows.labels();
  CondensedDistances distances(n);
  Sum kind{};
  const bool tiled = isTiled(comparison, kind);
  const Packed packed(tiled ? rows : DescriptorMatrix(labels), comparison == Comparison::cosine);

  static const auto sumsOf = ofThisProcessor(tile16, tile8, tile4);
  const auto byTiles = [&](std::size_t begin, std::size_t end) {
    float sums[tileRows * tileColumns];
    for (std::size_t j = begin / tileColumns * tileColumns; j < n; j += tileColumns)
      for (std::size_t i = begin; i < std::min(end, j + tileColumns); i += tileRows) {
        sumsOf(kind, packed.row(i), packed.columns(j), labels, sums);
        for (std::size_t r = i; r < std::min(i + tileRows, end); ++r)
          for (std::size_t c = std::max(j, r + 1); c < std::min(j + tileColumns, n); ++c)
            distances.after(r)[c - r - 1] =
                finish(comparison, sums[(r - i) * tileColumns + c - j], packed, r, c);
      }
  };
  const auto pairByPair = [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin + 1; j < n; ++j)
      for (std::size_t i = begin; i < std::min(end, j); ++i)
        distances.after(i)[j - i - 1] = compare(comparison, rows.row(i), rows.row(j));
  };

  const std::size_t blocks = (n + blockRows - 1) / blockRows;
  progress.begin("distances of all pairs", blocks);
  inParallel(blocks, threads, progress, "stopped while the distances of all pairs were computed",
             [&](std::size_t b) {
               const std::size_t begin = b * blockRows, end = std::min(n, begin + blockRows);
               tiled ? byTiles(begin, end) : pairByPair(begin, end);
             });
  progress.end();
  return distances;
}

}  // namespace estancia
