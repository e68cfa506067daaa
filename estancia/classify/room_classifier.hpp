// Room classifier: names the room of an image or a frame, with probabilities.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/describe/features.hpp"

namespace estancia {

class FeatureEmbedding;

/// A classifier of rooms with its descriptors, their embedding, and the names of the rooms. Cheap to copy;
/// safe to use from several threads.
///
///     const auto rooms = estancia::readRoomClassifier("home.classifier");
///     for (const auto& [room, p] : rooms.predict(image)) std::printf("%s %.2f\n", room.c_str(), p);
class RoomClassifier {
 public:
  struct Learned;
  explicit RoomClassifier(std::shared_ptr<const Learned> learned) : learned_(std::move(learned)) {}

  /// Sorted.
  const std::vector<std::string>& rooms() const;
  /// Number of training images over all rooms.
  std::size_t trainingImages() const;
  const FeatureEmbedding& embedding() const;
  const Classifier& classifier() const;
  /// Parameters and their cross-validation accuracy: "C 10, gamma 0.5: 77.1 % of held-out samples".
  std::string choice() const { return classifier().choice(); }

  /// The rooms of an image (BGR, 8 bits), best first; the probabilities add up to 1. Loads the descriptors on
  /// the first call. Throws Error when they are not installed, need depth, or are others than in training.
  std::vector<RoomProbability> predict(const cv::Mat& image) const;

  /// N × rooms probabilities that add up to 1. The features may have more parts than needed, in any order.
  /// Throws Error (mismatch) when a part is missing or another (model, vocabulary, parameters).
  DescriptorMatrix predict(const Features& features, int threads = 0) const;

 private:
  std::shared_ptr<const Learned> learned_;
};

/// Learns the rooms of frames[i].room; frames without are left out. Throws Error when there are fewer than
/// two rooms, or a room has one image only (insufficientData), or a value is not finite (invalidInput);
/// Interrupted.
RoomClassifier trainRoomClassifier(const Features& features, const ClassifierOptions& options = {},
                                   Progress& progress = Progress::none());

/// Throws Error (fileNotFound, fileUnreadable, unsupportedFile, corruptFile, malformedFile).
RoomClassifier readRoomClassifier(const std::filesystem::path& file);

/// Writes atomically. Throws Error (fileUnwritable).
void writeRoomClassifier(const RoomClassifier& classifier, const std::filesystem::path& file);

/// Whether the file begins as a room classifier, whatever its name.
bool isRoomClassifier(const std::filesystem::path& file);

}  // namespace estancia
