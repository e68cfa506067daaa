// Classifier: numbers → class probabilities; SVM, logistic regression, random forest, k nearest neighbors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {

class ByteReader;
class ByteWriter;

/// Training data. Invariant: one class and one group a row of x, classes 0 … classCount - 1.
struct Samples {
  /// N × columns, finite.
  DescriptorMatrix x;
  std::vector<int> classes;
  /// Rows of one group (a temporal segment, an object instance) are never split in cross-validation.
  std::vector<int> groups;
  /// At least 2.
  int classCount = 0;
};

/// Parameters that are not set are found by grouped cross-validation.
struct ClassifierOptions {
  std::string type = "svm-rbf";
  bool balanced = false;
  int folds = 5;
  std::uint64_t seed = 1;
  int threads = 0;

  std::optional<double> c = {};
  std::optional<double> gamma = {};
  std::optional<int> neighbors = {};
  std::string metric = "";
  int trees = 500;
};
OptionGroup declare(ClassifierOptions& options);

/// A trained classifier. Safe to use from several threads.
class Classifier {
 public:
  virtual ~Classifier() = default;
  virtual std::string type() const = 0;
  virtual std::size_t columns() const = 0;
  virtual int classCount() const = 0;

  /// Parameters and their cross-validation accuracy: "C 10, gamma 0.5: 77.1 % of held-out samples".
  virtual std::string choice() const = 0;

  /// N × classes probabilities that add up to 1; 0 for classes without training samples. `threads` = 0: one a
  /// usable core. Throws Error (mismatch, invalidInput) when x has not columns() columns or is not finite.
  virtual DescriptorMatrix predict(const DescriptorMatrix& x, int threads = 0) const = 0;

  /// For readClassifier().
  virtual void write(ByteWriter& out) const = 0;
};

/// svm-linear, svm-rbf, linear, forest, knn.
Choices classifierTypes();

/// Throws Error on invalid options, invalid samples (invalidInput, mismatch) and fewer than two classes with
/// samples (insufficientData); Interrupted.
std::unique_ptr<Classifier> trainClassifier(const Samples& samples, const ClassifierOptions& options,
                                            Progress& progress = Progress::none());

/// Reads what write() wrote. Throws Error (malformedFile, truncatedFile).
std::unique_ptr<Classifier> readClassifier(ByteReader& in);

}  // namespace estancia
