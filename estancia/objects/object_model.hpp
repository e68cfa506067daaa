// Object model: target classes and a classifier of 3-D shapes that was trained on the labels of images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/options.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

/// The classes of objects, with their names at labelers and in data sets (thesis 6.3). Invariant: at least
/// one class; names differ; no category belongs to two classes.
struct TargetClasses {
  struct Class {
    std::string name;
    /// Labels of labelers, as in a question: "coffee mug".
    std::vector<std::string> labels;
    /// Categories of data sets.
    std::vector<std::string> categories;
  };
  std::vector<Class> classes;

  std::vector<std::string> names() const;
  /// The class of a category; −1 for none of them.
  int classOf(const std::string& category) const;
};

/// Throws Error (invalidInput) on a breach of the invariant.
void validate(const TargetClasses& targets);

/// Reads TOML: a table `[classes.NAME]` a class with `labels` and `categories`, both its name by default.
/// Throws Error (fileNotFound, malformedFile).
TargetClasses readTargetClasses(const std::filesystem::path& file);

/// Each category is a class of its own name. Throws Error (invalidInput) as validate().
TargetClasses targetClassesOf(const std::vector<std::string>& categories);

struct ShapeOptions {
  int samples = 5000;
  bool size = false;
  std::uint64_t seed = 1;
  int threads = 0;
};
OptionGroup declare(ShapeOptions& options);

/// Embedding and classifier of shapes with their held-out accuracy. Cheap to copy; trained by
/// trainObjectModel().
class ObjectModel {
 public:
  struct Learned;
  explicit ObjectModel(std::shared_ptr<const Learned> learned) : learned_(std::move(learned)) {}

  const TargetClasses& targets() const;
  const ShapeOptions& shape() const;
  /// Identity of the labeler of the training data; "" for a person.
  const std::string& labeler() const;
  /// How often that labeler gave each class (priorOf()); empty: its answers are taken as they are.
  const std::vector<float>& prior() const;
  /// The accuracy of each predicted class on held-out training instances: the share of the samples predicted
  /// so that have that pseudo-label. −1 without such samples, or if the class could not be held out (one
  /// instance of a few samples). The only instance of a class is held out in parts. Pseudo-labels are taken
  /// for the truth; where confident learning removed samples, the estimate is optimistic.
  const std::vector<float>& heldOutAccuracy() const;
  /// See RoomClassifier::choice().
  std::string choice() const;

  /// N × classes; a row adds up to 1; 0 for classes without training samples. Throws Error (mismatch) on
  /// features of other shape options.
  DescriptorMatrix predict(const Features& shapes, int threads = 0) const;

 private:
  friend void writeObjectModel(const ObjectModel& model, const std::filesystem::path& file);
  std::shared_ptr<const Learned> learned_;
};

/// Throws Error (fileNotFound, fileUnreadable, unsupportedFile, corruptFile, malformedFile).
ObjectModel readObjectModel(const std::filesystem::path& file);

/// Writes atomically. Throws Error (fileUnwritable).
void writeObjectModel(const ObjectModel& model, const std::filesystem::path& file);

/// Whether the file begins as an object model, whatever its name.
bool isObjectModel(const std::filesystem::path& file);

}  // namespace estancia
