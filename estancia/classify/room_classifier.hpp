// Which room is this: descriptors in, names of rooms with probabilities out.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/embedding.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

/// A classifier of rooms with all that it needs to know of its input: the parts of the descriptor, how each
/// is embedded and standardized, the names of the rooms. Learned from training data alone. Cheap to copy.
class RoomClassifier {
 public:
  /// Learns the rooms of frames[i].room; frames without are left out. Throws Error when there are fewer than
  /// two rooms, a room has one image only, or a value is not finite (naming frame and column); Interrupted.
  static RoomClassifier train(const Features& features, const ClassifierOptions& options, Progress& progress);

  const std::vector<std::string>& rooms() const { return rooms_; }  ///< sorted
  const FeatureEmbedding& embedding() const {
    return embedding_;
  }  ///< the parts, and what was learned of each
  const Classifier& classifier() const { return *classifier_; }
  /// What was chosen and how well it did in cross-validation: "C 10, gamma 0.5: 77.1 % of what was held out".
  std::string choice() const { return classifier_->choice(); }

  /// N × rooms probabilities that add up to 1. The features may hold more parts than needed, in any order.
  /// Throws Error saying what differs when a part is missing or is another (model, vocabulary, parameters).
  DescriptorMatrix predict(const Features& features, int threads = 0) const;

  /// Versioned and checked; written whole or not at all. load() throws Error on anything that save() did not
  /// write, or a newer version wrote.
  void save(const std::filesystem::path& file) const;
  static RoomClassifier load(const std::filesystem::path& file);

 private:
  RoomClassifier(std::vector<std::string> rooms, FeatureEmbedding embedding,
                 std::shared_ptr<const Classifier> classifier);

  std::vector<std::string> rooms_;
  FeatureEmbedding embedding_;
  std::shared_ptr<const Classifier> classifier_;
};

/// Whether the file begins as a room classifier does, sound or not, whatever its name.
bool isRoomClassifier(const std::filesystem::path& file);

}  // namespace estancia
