// k nearest neighbors: the nearest training samples vote.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "estancia/classify/trainers.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/simd.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/products.hpp"

namespace estancia {
namespace {

constexpr int neighborCounts[] = {1, 3, 5, 9, 15, 25, 40};
constexpr std::size_t stripe = 32;  // keys that are looked at together
constexpr std::size_t spare = 4;    // candidates beyond k, as rounding may reorder neighbors

struct Neighbor {
  float distance;
  std::size_t row;
  bool operator<(const Neighbor& other) const {
    return distance != other.distance ? distance < other.distance : row < other.row;
  }
};

/// keys[j] = norms[j] − 2 products[j], which sorts as distances do; `minima`: the smallest of each stripe.
ESTANCIA_MULTIVERSION
void sortKeys(const float* norms, float* products, std::size_t n, float* minima) {
  for (std::size_t first = 0; first < n; first += stripe) {
    const std::size_t count = std::min(stripe, n - first);
    float smallest = std::numeric_limits<float>::infinity();
#pragma omp simd reduction(min : smallest)
    for (std::size_t j = first; j < first + count; ++j) {
      products[j] = norms[j] - 2 * products[j];
      smallest = products[j] < smallest ? products[j] : smallest;
    }
    minima[first / stripe] = smallest;
  }
}

/// The k smallest keys. Most stripes have none of them and are skipped.
std::vector<Neighbor> smallest(std::span<const float> keys, std::span<const float> minima, std::size_t k) {
  std::vector<Neighbor> heap;  // the largest on top
  heap.reserve(k + 1);
  for (std::size_t first = 0; first < keys.size(); first += stripe) {
    if (heap.size() == k && minima[first / stripe] >= heap.front().distance) continue;
    for (std::size_t j = first; j < std::min(first + stripe, keys.size()); ++j) {
      if (heap.size() == k && keys[j] >= heap.front().distance) continue;
      heap.push_back({keys[j], j});
      std::push_heap(heap.begin(), heap.end());
      if (heap.size() > k) {
        std::pop_heap(heap.begin(), heap.end());
        heap.pop_back();
      }
    }
  }
  std::sort(heap.begin(), heap.end());
  return heap;
}

/// Votes of the first k: weight of the class / distance. Samples at distance 0 outvote all others.
std::vector<double> votes(std::span<const Neighbor> neighbors, std::size_t k, const std::vector<int>& classes,
                          const std::vector<double>& weights) {
  std::vector<double> sums(weights.size());
  const bool same = neighbors.front().distance == 0;
  double all = 0;
  for (const Neighbor& neighbor : neighbors.first(std::min(k, neighbors.size()))) {
    if (same && neighbor.distance > 0) break;
    const auto c = static_cast<std::size_t>(classes[neighbor.row]);
    const double vote = weights[c] / (same ? 1 : neighbor.distance);
    sums[c] += vote;
    all += vote;
  }
  for (double& sum : sums) sum /= all;
  return sums;
}

/// Rows of length 1 (or 0): Euclidean distances sort as cosines. Throws Error if a length exceeds float32.
DescriptorMatrix toUnit(const DescriptorMatrix& x) {
  DescriptorMatrix result(x.labels());
  result.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    std::vector<float> row(x.row(i).begin(), x.row(i).end());
    const float norm = std::sqrt(dot(row, row));
    if (!std::isfinite(norm))
      fail(ErrorCode::invalidInput, "sample {} is too large for its norm in float32; scale the columns", i);
    if (norm > 0)
      for (float& value : row) value /= norm;
    result.append(row);
  }
  return result;
}

constexpr float maxSquared = 1e37F;  // sums of a few such stay finite

/// Column means. Sums do not overflow: the rows are float32.
std::vector<float> meanOf(const DescriptorMatrix& x) {
  std::vector<double> sums(x.labels());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t c = 0; c < sums.size(); ++c) sums[c] += x.row(i)[c];
  std::vector<float> mean;
  for (const double sum : sums) mean.push_back(static_cast<float>(sum / static_cast<double>(x.size())));
  return mean;
}

/// Centers the rows: dot products lose precision far from 0. Throws Error if products may exceed float32.
DescriptorMatrix centered(const DescriptorMatrix& x, std::span<const float> mean) {
  DescriptorMatrix result(x.labels());
  result.reserve(x.size());
  std::vector<float> row(x.labels());
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t c = 0; c < row.size(); ++c) row[c] = x.row(i)[c] - mean[c];
    if (!(dot(row, row) <= maxSquared))
      fail(ErrorCode::invalidInput,
           "sample {} is too far from the others for distances in float32; scale the columns", i);
    result.append(row);
  }
  return result;
}

/// Exact distances instead of the rounded keys; sorted.
void measure(const DescriptorMatrix& x, DescriptorView query, std::vector<Neighbor>& nearest) {
  for (Neighbor& neighbor : nearest)
    neighbor.distance = static_cast<float>(compare(Comparison::euclidean, query, x.row(neighbor.row)));
  std::sort(nearest.begin(), nearest.end());
}

/// k-nearest-neighbor classifier: the training rows with their classes. Invariant: `classes`, `packed` and
/// `norms` have one entry a row of `x`, `packed` and `norms` being centered by `mean`. Immutable once made,
/// so predict() may run on several threads.
class Knn final : public Classifier {
 public:
  /// For the cosine distance, rows must have length 1.
  Knn(DescriptorMatrix rows, std::vector<int> of, std::vector<double> weightsOfClasses, std::size_t k,
      bool unit, std::string how)
      : x(std::move(rows)),
        classes(std::move(of)),
        weights(std::move(weightsOfClasses)),
        neighbors(k),
        cosine(unit),
        chosen(std::move(how)),
        mean(meanOf(x)),
        packed(centered(x, mean)),
        norms(squaredNorms(centered(x, mean))) {}
  std::string type() const override { return "knn"; }
  std::size_t columns() const override { return x.labels(); }
  int classCount() const override { return static_cast<int>(weights.size()); }
  std::string choice() const override { return chosen; }
  DescriptorMatrix predict(const DescriptorMatrix& samples, int threads) const override {
    const DescriptorMatrix unit = cosine ? toUnit(samples) : DescriptorMatrix(0);
    const DescriptorMatrix& queries = cosine ? unit : samples;
    const std::size_t k = weights.size();
    std::vector<float> all(queries.size() * k);
    rowProducts(centered(queries, mean), packed, threads, [&](std::size_t i, std::span<float> products) {
      std::vector<float> minima((products.size() + stripe - 1) / stripe);
      sortKeys(norms.data(), products.data(), products.size(), minima.data());
      std::vector<Neighbor> nearest = smallest(products, minima, std::min(neighbors + spare, x.size()));
      measure(x, queries.row(i), nearest);
      const std::vector<double> p = votes(nearest, neighbors, classes, weights);
      std::copy(p.begin(), p.end(), all.begin() + static_cast<std::ptrdiff_t>(i * k));
    });
    return matrixOf(all, k);
  }

  void write(ByteWriter& out) const override {
    writeMatrix(out, x);
    out.numbers(std::vector<std::int32_t>(classes.begin(), classes.end()));
    out.numbers(weights);
    out.number(static_cast<std::uint64_t>(neighbors));
    out.number(static_cast<std::uint8_t>(cosine ? 1 : 0));
    out.text(chosen);
  }

 private:
  DescriptorMatrix x;
  std::vector<int> classes;
  std::vector<double> weights;
  std::size_t neighbors;
  bool cosine;
  std::string chosen;
  std::vector<float> mean;
  PackedRows packed;  ///< centered, as norms
  std::vector<float> norms;
};

/// The accuracy on held-out samples for each number of neighbors.
std::vector<double> scoresOf(const Search& search, bool cosine, const std::vector<int>& counts,
                             const ClassifierOptions& options, Progress& progress) {
  const std::size_t n = search.size();
  const auto maxCount = static_cast<std::size_t>(*std::max_element(counts.begin(), counts.end()));
  const DescriptorMatrix unit = cosine ? toUnit(search.x) : DescriptorMatrix(0);
  const DescriptorMatrix& x = cosine ? unit : search.x;
  const DescriptorMatrix moved = centered(x, meanOf(x));
  const std::vector<float> products = productsOf(moved, options.threads), norms = squaredNorms(moved);
  std::vector<std::vector<int>> right(n, std::vector<int>(counts.size()));  // times, of all repetitions
  progress.begin("choosing the number of neighbors", n);
  inParallel(
      n, options.threads, progress, "stopped while the number of neighbors was sought", [&](std::size_t i) {
        std::vector<Neighbor> all(n);
        for (std::size_t j = 0; j < n; ++j) {
          all[j] = {norms[j] - 2 * products[i * n + j], j};
        }
        std::sort(all.begin(), all.end());
        for (const std::vector<int>& folds : search.folds) {
          std::vector<Neighbor> nearest;
          for (const Neighbor& neighbor : all)
            if (folds[neighbor.row] != folds[i] && nearest.size() < maxCount + spare)
              nearest.push_back(neighbor);
          if (nearest.empty()) continue;
          measure(x, x.row(i), nearest);
          for (std::size_t c = 0; c < counts.size(); ++c) {
            const auto p =
                votes(nearest, static_cast<std::size_t>(counts[c]), search.classes, search.weights);
            right[i][c] += std::max_element(p.begin(), p.end()) - p.begin() == search.classes[i] ? 1 : 0;
          }
        }
      });
  progress.end();
  std::vector<double> scores(counts.size());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < counts.size(); ++c)
      scores[c] += search.weights[static_cast<std::size_t>(search.classes[i])] * right[i][c] /
                   static_cast<double>(n * Search::repetitions);
  return scores;
}

}  // namespace

std::unique_ptr<Classifier> trainKnn(const Samples& samples, const ClassifierOptions& options,
                                     Progress& progress) {
  const Search search = searchOf(samples, options);
  const std::vector<int> counts =
      options.neighbors ? std::vector<int>{*options.neighbors}
                        : std::vector<int>(std::begin(neighborCounts), std::end(neighborCounts));
  double best = -1;
  int neighbors = 0;
  bool cosine = false;
  for (const bool isCosine : {false, true}) {
    if (!options.metric.empty() && isCosine != (options.metric == "cosine")) continue;
    const std::vector<double> scores = scoresOf(search, isCosine, counts, options, progress);
    for (std::size_t c = 0; c < counts.size(); ++c) {
      if (scores[c] <= best) continue;
      best = scores[c];
      neighbors = counts[c];
      cosine = isCosine;
    }
  }
  return std::make_unique<Knn>(cosine ? toUnit(samples.x) : samples.x, samples.classes, search.weights,
                               static_cast<std::size_t>(neighbors), cosine,
                               fmt::format("{} neighbors, {}: {}", neighbors, cosine ? "cosine" : "Euclidean",
                                           heldOutText(best, options)));
}

std::unique_ptr<Classifier> readKnn(ByteReader& in) {
  DescriptorMatrix x = readMatrix(in);
  const auto classes = in.numbers<std::int32_t>();
  const auto weights = in.numbers<double>();
  const auto neighbors = in.number<std::uint64_t>();
  const auto cosine = in.number<std::uint8_t>();
  if (classes.size() != x.size() || classes.empty() || neighbors < 1)
    in.fail("it is damaged (samples and classes do not match)");
  for (const std::int32_t c : classes)
    if (c < 0 || static_cast<std::size_t>(c) >= weights.size()) in.fail("it is damaged (an unknown class)");
  for (const double weight : weights)
    if (!(weight > 0 && std::isfinite(weight))) in.fail("it is damaged (a weight is not above 0)");
  const std::size_t maxCount = std::min<std::uint64_t>(neighbors, x.size());
  std::string chosen = in.text();
  return std::make_unique<Knn>(std::move(x), std::vector<int>(classes.begin(), classes.end()), weights,
                               maxCount, cosine != 0, std::move(chosen));
}

}  // namespace estancia
