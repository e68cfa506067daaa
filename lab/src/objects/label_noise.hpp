// Label noise: wrong answers injected into class probabilities, to see how training withstands them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "estancia/objects/class_probabilities.hpp"

namespace estancia::experiments {

/// Injected label noise: `rate` (0 … 1) of the samples with an answer, chosen by `seed`, swap the probability
/// of their most probable class with that of another. view: each sample by itself; pair: always the next
/// class instead of any; instance: all samples of an object alike, by their fused class. With one seed, a
/// lower rate chooses a subset of a higher one. Throws Error (invalidOption) on another rate.
enum class NoiseKind { view, pair, instance };
ClassProbabilities withNoise(const ClassProbabilities& answers, NoiseKind kind, double rate,
                             std::span<const int> instances, std::uint64_t seed);

}  // namespace estancia::experiments
