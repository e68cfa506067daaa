// Pairwise coupling: decision values of pairs of classes → probabilities of all (Platt; Wu, Lin & Weng).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace estancia {

/// P(first of the two | decision value f) = 1 / (1 + exp(a f + b)) (Platt 2000).
struct Sigmoid {
  double a = -1, b = 0;
  double operator()(double decision) const;
};

/// Maximum likelihood with Platt's smoothed targets, by the method of Lin, Lin & Weng, "A note on Platt's
/// probabilistic outputs" (2007). Weights (one a value, ≥ 0) make the classes count alike. The default
/// sigmoid where one of the two classes has no values; never one that falls where decisions grow.
Sigmoid fitSigmoid(std::span<const double> decisions, std::span<const char> isFirst,
                   std::span<const double> weights);

/// Probabilities p of k classes from r[i·k + j] = P(i | i or j), r_ij + r_ji = 1: minimizes
/// Σ (r_ji p_i − r_ij p_j)² (Wu, Lin & Weng 2004, their second method). They add up to 1.
std::vector<double> couplePairs(std::span<const double> r, std::size_t k);

/// Where the pair i < j of k classes stands: (0, 1), (0, 2) … (1, 2) …
inline std::size_t pairIndex(std::size_t i, std::size_t j, std::size_t k) {
  return i * (2 * k - i - 1) / 2 + j - i - 1;
}

}  // namespace estancia
