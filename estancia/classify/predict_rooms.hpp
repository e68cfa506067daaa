// Room prediction: rooms for frames of a sequence or map, reusing known labels, and their confusion matrix.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/classify/room_classifier.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

/// The descriptors of this classifier, as describeSequence() takes them: "inception-v3+gist".
std::string descriptorOf(const RoomClassifier& classifier);

/// "svm-rbf on inception-v3+gist"
std::string nameOf(const RoomClassifier& classifier);

/// Throws Error (invalidInput, unknownName) unless images can be described by them on this machine.
void requireDescribable(const RoomClassifier& classifier);

/// Checks the frames of `sequence`, which needs depth if a descriptor does.
void requireDescribable(const RoomClassifier& classifier, const Sequence& sequence);

/// Throws Error (mismatch) unless these parts are all that the classifier needs.
void requireParts(const RoomClassifier& classifier, const std::vector<DescriptorPart>& parts);

/// One row for each of `frames`, found by name; all 0 if not there. Throws as RoomClassifier::predict().
RoomPredictions predictRooms(const RoomClassifier& classifier, const Features& features,
                             const std::vector<Frame>& frames, int threads = 0);

/// The features of the frames of `labels` for this classifier. Parts that the labels have are taken from
/// there; only the others are described, from `sequence`, which may be null if there are none. Frames that
/// cannot be described, or that the sequence lacks, are left out; the reasons go to `problems`. Throws Error
/// (mismatch, insufficientData), and as describeSequence(); Interrupted.
Features featuresFor(const RoomClassifier& classifier, const DescriptorSequence& labels,
                     const Sequence* sequence = nullptr, const DescribeOptions& options = {},
                     Progress& progress = Progress::none(), std::vector<std::string>* problems = nullptr);

/// {"image", "room", "probability", "rooms": {NAME: p}} of frame i; a `room` below `minProbability` is null.
nlohmann::ordered_json predictionJson(const RoomPredictions& predictions, const std::vector<Frame>& frames,
                                      std::size_t i, double minProbability = 0);

constexpr std::string_view predictionsCsvHeader =
    "image,predicted_room,probability,second,second_probability\n";
/// A line a frame; predicted_room is empty below the smallest probability.
std::string predictionsCsv(const RoomPredictions& predictions, const std::vector<Frame>& frames,
                           double minProbability = 0);

/// A confusion matrix. Invariant: square, one row and column a room.
struct Confusion {
  /// Sorted: all true and predicted rooms.
  std::vector<std::string> rooms;
  /// [truth][prediction]
  std::vector<std::vector<std::size_t>> counts;

  std::size_t total() const;
  /// Share of correct predictions.
  double accuracy() const;
  /// Mean recall of the rooms that occur in the truth.
  double balancedAccuracy() const;
};

/// Throws Error (mismatch) when the two are not equally long, or empty.
Confusion confusionOf(const std::vector<std::string>& truth, const std::vector<std::string>& predicted);

/// The most probable room of each row; the first in order of equals.
std::vector<std::string> mostProbable(const std::vector<std::string>& rooms,
                                      const DescriptorMatrix& probabilities);

/// Tests a classifier on the frames whose rooms are known; frames of rooms that it was not trained on count
/// as errors. Throws Error (insufficientData) when no room is known, and as RoomClassifier::predict().
Confusion testRooms(const RoomClassifier& classifier, const Features& features, int threads = 0);

}  // namespace estancia
