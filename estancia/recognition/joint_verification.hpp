// Joint verification: which instances of all models together explain the scene, each of its points once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/recognition/pose_candidates.hpp"

namespace estancia {

/// An instance with the evidence that remains for it among others.
struct VerifiedInstance {
  /// Indices of its model's candidates, and of the instance among them.
  std::size_t candidates = 0, instance = 0;
  /// Evidence from points that no better instance explains.
  double evidence = 0;
};

/// Hypotheses of several models exclude each other where they explain the same points of the scene, in the
/// manner of Aldoma et al. (ECCV 2012), who anneal: here the choice is exact for up to 24 that overlap. The
/// set with the most Σ (evidence − threshold) / scale is chosen, in which evidence on a point counts for the
/// better instance alone; of the chosen, those are kept whose own evidence still has a rate of false alarms
/// of at most `rate`. Most evident first.
std::vector<VerifiedInstance> verifyTogether(const std::vector<PoseCandidates>& candidates, double rate,
                                             int threads = 1);

/// The subset of items that maximizes Σ gains − Σ losses of its pairs: exactly by branch and bound for items
/// that losses connect, up to 24 of them, else greedily, largest gain first. `losses`: row-major,
/// gains.size()², symmetric, not negative. Ascending indices.
std::vector<std::size_t> bestSubset(const std::vector<double>& gains, const std::vector<double>& losses);

}  // namespace estancia
