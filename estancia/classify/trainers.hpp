// Trainers: one trainer and one reader for each type of classifier, and what they share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/bytes.hpp"
#include "estancia/core/frame.hpp"

namespace estancia {

/// Trainers get samples that trainClassifier() has checked: each class 0 … classCount − 1 has one.
std::unique_ptr<Classifier> trainSvm(const Samples& samples, const ClassifierOptions& options,
                                     Progress& progress);
std::unique_ptr<Classifier> readSvm(ByteReader& in);
std::unique_ptr<Classifier> trainKnn(const Samples& samples, const ClassifierOptions& options,
                                     Progress& progress);
std::unique_ptr<Classifier> readKnn(ByteReader& in);
std::unique_ptr<Classifier> trainForest(const Samples& samples, const ClassifierOptions& options,
                                        Progress& progress);
std::unique_ptr<Classifier> readForest(ByteReader& in);
std::unique_ptr<Classifier> trainLinear(const Samples& samples, const ClassifierOptions& options,
                                        Progress& progress);
std::unique_ptr<Classifier> readLinear(ByteReader& in);

/// Σ weights of each class are equal, and of all samples N; all 1 unless balanced.
std::vector<double> classWeights(const Samples& samples, bool balanced);

/// Samples as libsvm and liblinear want them.
struct OrderedByClass {
  /// Class by class, since both number the classes as they appear.
  std::vector<std::size_t> rows;
  /// The class of each row.
  std::vector<double> y;
  /// The classes with samples, and their weights.
  std::vector<int> labels;
  std::vector<double> weights;
};
OrderedByClass orderByClass(std::vector<std::size_t> rows, const std::vector<int>& classes,
                            const std::vector<double>& weights);

/// These rows, in that order.
DescriptorMatrix rowsOf(const DescriptorMatrix& matrix, const std::vector<std::size_t>& rows);

/// Rows of so many columns, one after the other.
DescriptorMatrix matrixOf(std::span<const float> values, std::size_t columns);

void writeMatrix(ByteWriter& out, const DescriptorMatrix& matrix);
/// Throws Error (malformedFile) when a value is not finite.
DescriptorMatrix readMatrix(ByteReader& in);

/// The samples of a search: of many, some of each class, evenly spread: its time grows with their square.
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

// ---- grouped cross-validation: neighboring images stay in one fold

/// One group a temporal segment of one room (core/temporal_segments.hpp). The longest segments of a room with
/// fewer than `minSegments` are cut, but not below a few frames: each room can be learned and held out.
std::vector<int> segmentGroups(const std::vector<Frame>& frames, int minSegments);

/// One group an object instance of several samples. A class with only one instance has it cut into up to
/// `pieces` of a few neighboring samples, so that the class can be learned and held out. `classes`,
/// `instances` and the result have the same length.
std::vector<int> instanceGroups(const std::vector<int>& classes, const std::vector<int>& instances,
                                int pieces);

/// The fold (0 … folds − 1) of each sample: groups whole, classes spread as evenly as possible. Greedy, the
/// largest groups first; equal ones in an order shuffled by the seed.
std::vector<int> groupedFolds(const std::vector<int>& classes, const std::vector<int>& groups, int folds,
                              std::uint64_t seed);

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
