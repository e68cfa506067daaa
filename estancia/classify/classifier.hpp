// Numbers → probabilities of classes: the one interface of all classifiers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

/// What a classifier learns from. Invariant: one class and one group a row of x, classes 0 … count - 1.
struct Samples {
  DescriptorMatrix x;        ///< N × columns, finite
  std::vector<int> classes;  ///< N
  std::vector<int> groups;   ///< N; rows of one group (a run of images of one room) never part in validation
  int classCount = 0;        ///< at least 2
};

struct ClassifierOptions {
  std::string type = "svm-rbf";  ///< one of classifierTypes()
  bool balanced = true;          ///< each class counts alike, however many samples it has
  int folds = 5;                 ///< of the grouped cross-validation that finds what is not given below
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one a free core; the result does not depend on it
  // One struct a classifier follows: C, gamma, trees, neighbours …; absent means: search.
};

/// A trained classifier. Safe to use from several threads.
class Classifier {
 public:
  virtual ~Classifier() = default;
  virtual std::string type() const = 0;
  virtual std::size_t columns() const = 0;
  virtual int classCount() const = 0;

  /// N × classes probabilities that add up to 1. `threads` = 0: one a free core.
  virtual DescriptorMatrix predict(const DescriptorMatrix& x, int threads = 0) const = 0;
};

/// svm-linear, svm-rbf, linear, forest, knn, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> classifierTypes();

/// Throws Error on an unknown type (listing the known ones), fewer than two classes with samples, values that
/// are not finite; Interrupted when the user asks to stop.
std::unique_ptr<Classifier> trainClassifier(const Samples& samples, const ClassifierOptions& options,
                                            Progress& progress);

}  // namespace estancia
