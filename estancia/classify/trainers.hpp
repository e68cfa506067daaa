// Trainers: one trainer and one reader for each type of classifier, for classifier.cpp.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/bytes.hpp"

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

}  // namespace estancia
