// Confusion matrix: rooms predicted against true rooms, with their accuracy.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/classify/room_classifier.hpp"

namespace estancia {

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
