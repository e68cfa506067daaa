// SPDX-License-Identifier: Apache-2.0
#include "estancia/distances/distance.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "estancia/core/fail.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::string_view sigmaSuffix = "-sigma";
constexpr const char* sigmaExplanation = ", labels that vary within the node have less weight";

/// ln x of a finite x > 0, good to about 1e-7 and without a call, so that loops over labels stay vectors:
/// x = 2ᵏ y with y in [√½, √2), ln y = 2 artanh((y − 1) / (y + 1)).
[[gnu::always_inline]] inline float logarithm(float x) {
  constexpr std::int32_t rootOfHalf = 0x3F3504F3;  // its bits
  const auto bits = std::bit_cast<std::int32_t>(x) - rootOfHalf;
  const auto y = std::bit_cast<float>((bits & 0x007FFFFF) + rootOfHalf);
  const float t = (y - 1) / (y + 1), t2 = t * t;
  constexpr float ln2 = 0.693147181F;
  return static_cast<float>(bits >> 23) * ln2 +
         2 * t * (1 + t2 * (1.0F / 3 + t2 * (1.0F / 5 + t2 * (1.0F / 7 + t2 * (1.0F / 9)))));
}

/// ln(1 + u) of u in [−1, 1], with the digits that 1 + u loses; finite at −1: (1 + u) ln(1 + u) is 0.
[[gnu::always_inline]] inline float logarithmOfOnePlus(float u) {
  const float y = std::max(1 + u, 1e-30F);
  return logarithm(y) + (u - (y - 1)) / y;
}

/// Σ w and Σ w·term(a, b); without weights Σ w is n.
struct Sums {
  float weights, value;
};

template <class Term>
[[gnu::always_inline]] inline Sums accumulate(const float* a, const float* b, const float* w, std::size_t n,
                                              Term term) {
  float sum = 0, weights = 0;
  if (w == nullptr) {
#pragma omp simd reduction(+ : sum)
    for (std::size_t i = 0; i < n; ++i) sum += term(a[i], b[i]);
    return {static_cast<float>(n), sum};
  }
#pragma omp simd reduction(+ : sum, weights)
  for (std::size_t i = 0; i < n; ++i) {
    weights += w[i];
    sum += w[i] * term(a[i], b[i]);
  }
  return {weights, sum};
}

ESTANCIA_MULTIVERSION
Sums products(const float* a, const float* b, const float* w, std::size_t n) {
  return accumulate(a, b, w, n, [](float x, float y) { return x * y; });
}

ESTANCIA_MULTIVERSION
Sums squares(const float* a, const float* b, const float* w, std::size_t n) {
  return accumulate(a, b, w, n, [](float x, float y) { return (x - y) * (x - y); });
}

ESTANCIA_MULTIVERSION
Sums magnitudes(const float* a, const float* b, const float* w, std::size_t n) {
  return accumulate(a, b, w, n, [](float x, float y) { return std::fabs(x - y); });
}

ESTANCIA_MULTIVERSION
Sums chiSquares(const float* a, const float* b, const float* w, std::size_t n) {
  return accumulate(a, b, w, n, [](float x, float y) {
    const float s = x + y;
    return (x - y) * (x - y) / (s > 0 ? s : 1);
  });
}

ESTANCIA_MULTIVERSION
Sums jeffreys(const float* a, const float* b, const float* w, std::size_t n) {
  return accumulate(a, b, w, n, [](float x, float y) {
    const float larger = std::max(std::max(x, y), 0.0F), smaller = std::max(std::min(x, y), 0.0F);
    return (larger - smaller) * logarithm((larger + clrFloor) / (smaller + clrFloor));
  });
}

/// With u = (a − b) / (a + b) the term a ln(a / m) + b ln(b / m) is m [(1 + u) ln(1 + u) + (1 − u) ln(1 −
/// u)], in which nothing cancels that is large.
ESTANCIA_MULTIVERSION
Sums jensenShannons(const float* a, const float* b, const float* w, std::size_t n) {
  return accumulate(a, b, w, n, [](float x, float y) {
    const float p = std::max(x, 0.0F), q = std::max(y, 0.0F), s = p + q;
    const float u = (p - q) / (s > 0 ? s : 1);
    return s * 0.5F * ((1 + u) * logarithmOfOnePlus(u) + (1 - u) * logarithmOfOnePlus(-u));
  });
}

ESTANCIA_MULTIVERSION
Sums maxima(const float* a, const float* b, const float* w, std::size_t n) {
  float largest = 0, weights = 0;
  if (w == nullptr) {
#pragma omp simd reduction(max : largest)
    for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
    return {static_cast<float>(n), largest};
  }
#pragma omp simd reduction(max : largest) reduction(+ : weights)
  for (std::size_t i = 0; i < n; ++i) {
    weights += w[i];
    largest = std::max(largest, w[i] * std::fabs(a[i] - b[i]));
  }
  return {weights, largest};
}

/// Weights are relative: `labels` times the weighted mean.
double rescaled(const Sums& sums, std::size_t labels) {
  return sums.weights > 0 ? static_cast<double>(labels) * sums.value / sums.weights : 0;
}

double cosine(const Sums& ab, const Sums& aa, const Sums& bb) {
  const double norms = std::sqrt(static_cast<double>(aa.value) * bb.value);
  if (norms > 0) return ab.value / norms;
  return aa.value == bb.value ? 1 : 0;  // zero vectors have no direction: equal among themselves only
}

void center(std::span<float> values) {
  double sum = 0;
  for (const float value : values) sum += value;
  const auto mean = static_cast<float>(sum / static_cast<double>(values.size()));
  for (float& value : values) value -= mean;
}

void toLogRatios(std::span<float> p) {
  const float missing = missingProbability(p);
  for (float& value : p) value = std::log((value > 0 ? value : missing) + clrFloor);
  center(p);
}

void sumUp(std::span<float> values) {
  double sum = 0;
  for (float& value : values) value = static_cast<float>(sum += value);
}

template <class Change>
void inEachPart(std::span<float> values, std::span<const LabelPart> parts, Change change) {
  if (parts.empty()) return change(values);
  for (std::size_t first = 0; const LabelPart& part : parts) {
    change(values.subspan(first, part.size));
    first += part.size;
  }
}

Distance distanceOf(const char* name, Embedding embedding, Comparison comparison, double tauJoin,
                    const char* explanation, bool standardized = false, bool sigmaWeighted = false) {
  return {name, embedding, comparison, standardized, sigmaWeighted, {}, tauJoin, explanation};
}

}  // namespace

const std::vector<Distance>& baseDistances() {
  using enum Embedding;
  using enum Comparison;
  static const std::vector<Distance> all = {
      distanceOf("standardized-clr", centeredLogRatio, cosine, 0.5,
                 "cosine of log-ratios, each label centered and scaled by the run's own mean and deviation",
                 true),
      distanceOf("clr-cosine", centeredLogRatio, cosine, 0.3,
                 "cosine of centered log-ratios (Aitchison's geometry)"),
      distanceOf("clr-euclidean", centeredLogRatio, euclidean, 40,
                 "Euclidean distance of centered log-ratios (Aitchison distance)"),
      distanceOf("hellinger", squareRoot, euclidean, 0.8, "Euclidean distance of square roots, in [0, √2]"),
      distanceOf("bhattacharyya", squareRoot, bhattacharyya, 0.4, "−ln of the Bhattacharyya coefficient"),
      distanceOf("jensen-shannon", identity, jensenShannon, 0.5,
                 "Jensen–Shannon distance (the root of the divergence), in [0, √ln 2]"),
      distanceOf("kullback-leibler", identity, kullbackLeibler, 3,
                 "Kullback–Leibler divergence, both directions added up"),
      distanceOf("l1", identity, l1, 1.2, "Manhattan distance of probabilities"),
      distanceOf("l2", identity, euclidean, 0.4, "Euclidean distance of probabilities"),
      distanceOf("cosine", identity, cosine, 0.5, "cosine of probabilities"),
      distanceOf("pearson", centered, cosine, 0.5, "1 − Pearson's correlation of probabilities"),
      distanceOf("chi2", identity, chiSquared, 0.6, "χ² distance of probabilities"),
      distanceOf("ks", identity, chebyshev, 0.4, "the thesis' Eq. 5.1: the largest difference of any label"),
      distanceOf(
          "cumulative-ks", cumulative, chebyshev, 0.3,
          "Kolmogorov–Smirnov: the largest difference of probabilities summed up in the labels' order"),
      distanceOf("weighted", identity, meanSquare, 1e-4,
                 "the thesis' Eq. 4.5: mean of squared differences, weights 1 − 2σ", false, true),
      distanceOf("weighted-root", identity, rootMeanSquare, 0.01,
                 "the root of Eq. 4.5, as the thesis' program computed it", false, true),
  };
  return all;
}

Choices distances() {
  Choices all;
  for (const Distance& distance : baseDistances()) {
    all.push_back({distance.name, distance.explanation});
    if (!distance.sigmaWeighted)
      all.push_back({distance.name + std::string(sigmaSuffix), distance.explanation + sigmaExplanation});
  }
  return all;
}

Distance getDistance(std::string_view name, const std::vector<LabelPart>& parts) {
  std::string_view base = name;
  const bool sigma = base.size() > sigmaSuffix.size() && base.ends_with(sigmaSuffix);
  if (sigma) base.remove_suffix(sigmaSuffix.size());
  for (const Distance& distance : baseDistances()) {
    if (distance.name != base || (sigma && distance.sigmaWeighted)) continue;
    Distance result = distance;
    result.parts = parts;
    if (!sigma) return result;
    result.name += sigmaSuffix;
    result.sigmaWeighted = true;
    result.explanation += sigmaExplanation;
    return result;
  }
  fail(ErrorCode::unknownName, "unknown distance \"{}\"; known: {}", name, namesOf(distances()));
}

float missingProbability(std::span<const float> p) {
  float least = std::numeric_limits<float>::infinity();
  bool isWhole = true;
  for (const float value : p) {
    isWhole &= value > 0;
    if (value > 0) least = std::min(least, value);
  }
  return isWhole || std::isinf(least) ? 0 : least / 2;
}

void embed(Embedding embedding, std::span<const float> p, std::span<float> out,
           std::span<const LabelPart> parts) {
  switch (embedding) {
    case Embedding::identity:
      std::copy(p.begin(), p.end(), out.begin());
      return;
    case Embedding::squareRoot:
      for (std::size_t i = 0; i < p.size(); ++i) out[i] = std::sqrt(std::max(p[i], 0.0F));
      return;
    case Embedding::centered:
      std::copy(p.begin(), p.end(), out.begin());
      return inEachPart(out, parts, center);
    case Embedding::cumulative:
      std::copy(p.begin(), p.end(), out.begin());
      return inEachPart(out, parts, sumUp);
    case Embedding::centeredLogRatio:
      std::copy(p.begin(), p.end(), out.begin());
      return inEachPart(out, parts, toLogRatios);
  }
}

float dot(std::span<const float> a, std::span<const float> b) {
  return products(a.data(), b.data(), nullptr, a.size()).value;
}

double compare(Comparison comparison, std::span<const float> a, std::span<const float> b,
               std::span<const float> weights) {
  if (a.size() != b.size() || (!weights.empty() && weights.size() != a.size()))
    fail(ErrorCode::mismatch, "descriptors have {} and {} labels, and {} weights; give as many of each",
         a.size(), b.size(), weights.size());
  const float *x = a.data(), *y = b.data(), *w = weights.empty() ? nullptr : weights.data();
  const std::size_t n = a.size();
  switch (comparison) {
    case Comparison::meanSquare:
      return rescaled(squares(x, y, w, n), 1);
    case Comparison::rootMeanSquare:
      return std::sqrt(rescaled(squares(x, y, w, n), 1));
    case Comparison::euclidean:
      return std::sqrt(rescaled(squares(x, y, w, n), n));
    case Comparison::l1:
      return rescaled(magnitudes(x, y, w, n), n);
    case Comparison::chebyshev:
      return rescaled(maxima(x, y, w, n), n);
    case Comparison::kullbackLeibler:
      return std::max(0.0, rescaled(jeffreys(x, y, w, n), n));
    case Comparison::jensenShannon:
      return std::sqrt(std::max(0.0, 0.5 * rescaled(jensenShannons(x, y, w, n), n)));
    case Comparison::chiSquared:
      return 0.5 * rescaled(chiSquares(x, y, w, n), n);
    case Comparison::bhattacharyya:
      return -std::log(
          std::clamp(cosine(products(x, y, w, n), products(x, x, w, n), products(y, y, w, n)), 1e-12, 1.0));
    case Comparison::cosine:
      return std::clamp(1 - cosine(products(x, y, w, n), products(x, x, w, n), products(y, y, w, n)), 0.0,
                        2.0);
  }
  throw Error(ErrorCode::invalidOption, "the comparison is none of Comparison; give one of its values");
}

}  // namespace estancia
