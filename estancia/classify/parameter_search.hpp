// Parameter search: samples, folds and kernel products for cross-validation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"

namespace estancia {

/// The samples of a search: of many, some of each class, evenly spread, as the time of a search grows with
/// their square and its result hardly changes.
struct Search {
  static constexpr std::size_t maxSamples = 3000;
  /// Number of shuffles of the folds: the score of one alone is noisy.
  static constexpr std::size_t repetitions = 3;

  DescriptorMatrix x{0};
  std::vector<int> classes;
  /// Fold of each sample, one vector a repetition.
  std::vector<std::vector<int>> folds;
  /// Class weights; all 1 unless balanced.
  std::vector<double> weights;

  std::size_t size() const { return classes.size(); }
  /// The samples of the other folds; none if they are of one class.
  std::vector<std::size_t> trainingRows(const std::vector<int>& foldOf, int fold) const;
};

/// At most `maxSamples`, but one of each class.
Search searchOf(const Samples& samples, const ClassifierOptions& options,
                std::size_t maxSamples = Search::maxSamples);

/// "79.5 % of held-out samples", for a share of the weights.
std::string heldOutText(double share, const ClassifierOptions& options);

/// work() under a line of progress: the libraries do not report theirs.
template <class Work>
auto learnFromAll(const Samples& samples, Progress& progress, Work work) {
  progress.begin(fmt::format("learning from all {} images", samples.x.size()), 1);
  auto learned = work();
  progress.advance();
  progress.end();
  return learned;
}

/// x xᵀ, n × n.
std::vector<float> productsOf(const DescriptorMatrix& x, int threads);

}  // namespace estancia
