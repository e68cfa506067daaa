// What all searches for the best parameters share: samples, folds, and products of all pairs.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"

namespace estancia {

/// Samples to search with. When there are many, some of each class, evenly spread: the time of a search grows
/// with their square, and what is found hardly changes.
struct Search {
  static constexpr std::size_t most = 3000;  ///< samples
  /// The folds are shuffled anew so many times: the score of one alone is a matter of luck.
  static constexpr std::size_t repetitions = 3;

  DescriptorMatrix x{0};
  std::vector<int> classes;
  std::vector<std::vector<int>> folds;  ///< of each sample, for each repetition
  std::vector<double> weights;          ///< of the classes; all 1 unless balanced

  std::size_t size() const { return classes.size(); }
};

/// At most `most` samples, but one of each class.
Search searchOf(const Samples& samples, const ClassifierOptions& options, std::size_t most = Search::most);

/// "79.5 % of what was held out", for a share of the weights.
std::string heldOut(double share, const ClassifierOptions& options);

/// work() under a line of progress: libraries that learn do not say how far they are.
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
