// Scene statistics: scores of descriptors and classifiers, and the cost of choosing the best.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "estancia/stats/method_comparison.hpp"
#include "scenes/scenes_findings.hpp"

namespace estancia::experiments {

/// Fewer pairs of training and test than this allow no conclusion by ranks: even if one method wins them all,
/// a two-sided signed-rank test of 5 cannot fall below 5 % (2 / 2⁵).
inline constexpr std::size_t minPairs = 6;

/// What Friedman's test takes for its tests.
struct SceneBlocks {
  /// Else whole pairs, as in the thesis.
  bool runs = false;
  /// Each once.
  std::vector<std::string> names;
  /// right[block][cell]: right answers of all seeds; cell = descriptor · classifiers + classifier. Shares are
  /// divided last: a sum of shares differs in its last bit from an equal one, which ranks would count.
  std::vector<std::vector<std::size_t>> right;
  /// Answers of each cell in each block, right or wrong.
  std::vector<std::size_t> answers;
};

/// Whole pairs of training and test where there are at least `minPairs`. Else the runs of the test images
/// (of pairs whose test was not learned): each shows one place, which no training image shows and which
/// answers for all its images, so that the runs are independent witnesses of the classifiers as they were
/// trained. (Where a run is one image, Friedman's test is Cochran's Q.)
SceneBlocks blocksOf(const ScenesResults& results);

/// All cells, named "descriptor/classifier".
MethodScores scoresOfCells(const ScenesResults& results, const SceneBlocks& blocks);
/// Descriptors by their mean over the classifiers, and the other way round.
MethodScores scoresOfDescriptors(const ScenesResults& results, const SceneBlocks& blocks);
MethodScores scoresOfClassifiers(const ScenesResults& results, const SceneBlocks& blocks);

/// CSV for `estancia compare`: a row a test, its name first, then a column a method.
std::string scoresCsv(const MethodScores& scores);

/// Mean accuracy over the pairs of each cell of `cells` (their numbers as in SceneBlocks), in their order.
std::vector<double> meanAccuracies(const ScenesResults& results, const std::vector<std::size_t>& cells);

/// What the best of `cells` is worth when the test that it was chosen by is not the one that it is measured
/// by: chosen on runs drawn with repetition, measured on those that were not drawn, over 1,000 draws
/// (bootstrap bias correction; Tsamardinos et al., Machine Learning 107 (2018), who find it a little too
/// low). Both by the mean over the pairs, as meanAccuracies(); cells that are chosen alike are measured by
/// their mean. Never above the plain accuracy of the best.
double accuracyOfChoice(const ScenesResults& results, const std::vector<std::size_t>& cells,
                        std::uint64_t seed);

}  // namespace estancia::experiments
