// What was learned of the shapes of a study's words.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/embedding.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/target_classes.hpp"

namespace estancia {

/// What a model is learned from. Invariant: as many words and instances as rows of `shapes`.
struct ObjectTraining {
  TargetClasses study;
  ShapeOptions shape;  ///< that `shapes` were made with
  Features shapes;
  std::vector<int> words;      ///< of the study; −1 is left out
  std::vector<int> instances;  ///< samples of one never part in validation
  std::string labeler;         ///< identity of who gave the words; "" for a person
  std::vector<float> prior;    ///< of that labeler (priorOf()); empty: answers are taken as they are
};

/// Embedding, classifier, and how well it and the names agreed. Cheap to copy.
class ObjectModel {
 public:
  /// Throws Error when fewer than two words have samples (naming those that do) or a value is not finite;
  /// Interrupted.
  static ObjectModel train(const ObjectTraining& training, const ClassifierOptions& options,
                           Progress& progress);

  const TargetClasses& study() const;
  const ShapeOptions& shape() const;
  const std::string& labeler() const;
  const std::vector<float>& prior() const;
  /// How often the shape is right when it says a word: of the training samples that were held out, by
  /// instances, and taken for that word, the share that is named so; −1 where there were none, or the word
  /// could not be held out (one instance of a few samples). Instances that are the only ones of a word are
  /// held out in parts. The truth here is what the labeler said; where samples
  /// that shapes speak against were left out (Naming::confident), it looks better than it is.
  const std::vector<float>& agreement() const;
  std::string choice() const;  ///< as RoomClassifier::choice()

  /// N × words; a row adds up to 1; 0 for words without samples. Throws Error when the shapes are other ones.
  DescriptorMatrix predict(const Features& shapes, int threads = 0) const;

  /// Versioned and checked; written whole or not at all. load() throws Error on anything that save() did not
  /// write, or a newer version wrote.
  void save(const std::filesystem::path& file) const;
  static ObjectModel load(const std::filesystem::path& file);

 private:
  struct Learned;
  explicit ObjectModel(std::shared_ptr<const Learned> learned);
  std::shared_ptr<const Learned> learned_;
};

/// Whether the file begins as one does, sound or not.
bool isObjectModel(const std::filesystem::path& file);

}  // namespace estancia
