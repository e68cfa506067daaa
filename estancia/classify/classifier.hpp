// Numbers → probabilities of classes: the one interface of all classifiers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

class ByteReader;
class ByteWriter;

/// What a classifier learns from. Invariant: one class and one group a row of x, classes 0 … count - 1.
struct Samples {
  DescriptorMatrix x;        ///< N × columns, finite
  std::vector<int> classes;  ///< N
  std::vector<int> groups;   ///< N; rows of one group (a run of images of one room) never part in validation
  int classCount = 0;        ///< at least 2
};

struct ClassifierOptions {
  std::string type = "svm-rbf";  ///< one of classifierTypes()
  bool balanced = false;         ///< each class counts alike, however many samples it has
  int folds = 5;                 ///< of the grouped cross-validation that finds what is not given below
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one a usable core; the result does not depend on it

  /// svm-linear, svm-rbf, linear: what an error costs, > 0; the larger, the closer the training set is
  /// followed.
  std::optional<double> c = {};
  std::optional<double> gamma = {};   ///< svm-rbf: k(a, b) = exp(−gamma |a − b|²), > 0
  std::optional<int> neighbors = {};  ///< knn: how many vote
  std::string metric = "";            ///< knn: "euclidean" or "cosine"; "": the better one
  int trees = 500;                    ///< forest
};

/// A trained classifier. Safe to use from several threads.
class Classifier {
 public:
  virtual ~Classifier() = default;
  virtual std::string type() const = 0;
  virtual std::size_t columns() const = 0;
  virtual int classCount() const = 0;

  /// What training chose and how well that did: "C 10, gamma 0.5: 77.1 % of what was held out".
  virtual std::string choice() const = 0;

  /// N × classes probabilities that add up to 1; 0 for classes without training samples. `threads` = 0: one a
  /// usable core. Throws Error when x has not columns() columns or holds what is not finite.
  virtual DescriptorMatrix predict(const DescriptorMatrix& x, int threads = 0) const = 0;

  /// For readClassifier().
  virtual void write(ByteWriter& out) const = 0;
};

/// svm-linear, svm-rbf, linear, forest, knn, each with one line of explanation.
std::vector<std::pair<std::string, std::string>> classifierTypes();

/// Throws Error on an unknown type (listing the known ones), options out of range, fewer than two classes
/// with samples, values that are not finite; Interrupted when the user asks to stop.
std::unique_ptr<Classifier> trainClassifier(const Samples& samples, const ClassifierOptions& options,
                                            Progress& progress);

/// What write() wrote. Throws Error on anything else.
std::unique_ptr<Classifier> readClassifier(ByteReader& in);

}  // namespace estancia
