#include "estancia/stats/distance.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

constexpr std::string_view sigmaSuffix = "-sigma";

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

/// Weights are relative: `labels` times the weighted mean.
double rescaled(const Sums& sums, std::size_t labels) {
  return sums.weights > 0 ? static_cast<double>(labels) * sums.value / sums.weights : 0;
}

double cosine(const Sums& ab, const Sums& aa, const Sums& bb) {
  const double norms = std::sqrt(static_cast<double>(aa.value) * bb.value);
  if (norms > 0) return ab.value / norms;
  return aa.value == bb.value ? 1 : 0;  // zero vectors point nowhere: alike among themselves only
}

void centre(std::span<float> values) {
  double sum = 0;
  for (const float value : values) sum += value;
  const auto mean = static_cast<float>(sum / static_cast<double>(values.size()));
  for (float& value : values) value -= mean;
}

}  // namespace

const std::vector<Distance>& baseDistances() {
  static const std::vector<Distance> all = {
      {"standardized-clr",
       Embedding::centredLogRatio,
       Comparison::cosine,
       true,
       false,
       {},
       0.5,
       "cosine of log-ratios, each label centred and scaled by the run's own mean and spread"},
      {"clr-cosine",
       Embedding::centredLogRatio,
       Comparison::cosine,
       false,
       false,
       {},
       0.3,
       "cosine of centred log-ratios (Aitchison's geometry)"},
      {"clr-euclidean",
       Embedding::centredLogRatio,
       Comparison::euclidean,
       false,
       false,
       {},
       40,
       "Euclidean distance of centred log-ratios (Aitchison distance)"},
      {"hellinger",
       Embedding::squareRoot,
       Comparison::euclidean,
       false,
       false,
       {},
       0.8,
       "Euclidean distance of square roots, in [0, √2]"},
      {"bhattacharyya",
       Embedding::squareRoot,
       Comparison::bhattacharyya,
       false,
       false,
       {},
       0.4,
       "−ln of the Bhattacharyya coefficient"},
      {"l1",
       Embedding::identity,
       Comparison::l1,
       false,
       false,
       {},
       1.2,
       "Manhattan distance of probabilities"},
      {"l2",
       Embedding::identity,
       Comparison::euclidean,
       false,
       false,
       {},
       0.4,
       "Euclidean distance of probabilities"},
      {"chi2",
       Embedding::identity,
       Comparison::chiSquared,
       false,
       false,
       {},
       0.6,
       "χ² distance of probabilities"},
      {"weighted",
       Embedding::identity,
       Comparison::meanSquare,
       false,
       true,
       {},
       1e-4,
       "the thesis' Eq. 4.5: mean of squared differences, weights 1 − 2σ"},
      {"weighted-root",
       Embedding::identity,
       Comparison::rootMeanSquare,
       false,
       true,
       {},
       0.01,
       "the root of Eq. 4.5, as the thesis' program computed it"},
  };
  return all;
}

Distance getDistance(std::string_view name, const std::vector<LabelPart>& parts) {
  std::string_view base = name;
  const bool sigma = base.size() > sigmaSuffix.size() && base.ends_with(sigmaSuffix);
  if (sigma) base.remove_suffix(sigmaSuffix.size());
  std::vector<std::string> known;
  for (const Distance& distance : baseDistances()) {
    if (distance.name == base && !(sigma && distance.sigmaWeighted)) {
      Distance result = distance;
      result.parts = parts;
      if (sigma) {
        result.name += sigmaSuffix;
        result.sigmaWeighted = true;
        result.explanation += ", labels that vary inside the node weigh less";
      }
      return result;
    }
    known.push_back(distance.name);
  }
  throw Error(
      fmt::format("no distance is called \"{}\"; there are {} (all but the weighted ones also with -sigma)",
                  name, fmt::join(known, ", ")));
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
    case Embedding::centredLogRatio:
      for (std::size_t i = 0; i < p.size(); ++i) out[i] = std::log(std::max(p[i], 0.0F) + clrFloor);
      if (parts.empty()) return centre(out);
      for (std::size_t first = 0; const LabelPart& part : parts) {
        centre(out.subspan(first, part.size));
        first += part.size;
      }
      return;
  }
}

float dot(std::span<const float> a, std::span<const float> b) {
  return products(a.data(), b.data(), nullptr, a.size()).value;
}

double compare(Comparison comparison, std::span<const float> a, std::span<const float> b,
               std::span<const float> weights) {
  if (a.size() != b.size() || (!weights.empty() && weights.size() != a.size()))
    throw Error(fmt::format("cannot compare descriptors of {} and {} labels", a.size(), b.size()));
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
    case Comparison::chiSquared:
      return 0.5 * rescaled(chiSquares(x, y, w, n), n);
    case Comparison::bhattacharyya:
      return -std::log(
          std::max(cosine(products(x, y, w, n), products(x, x, w, n), products(y, y, w, n)), 1e-12));
    case Comparison::cosine:
      return std::clamp(1 - cosine(products(x, y, w, n), products(x, x, w, n), products(y, y, w, n)), 0.0,
                        2.0);
  }
  throw Error("a comparison of unknown kind");
}

}  // namespace estancia
