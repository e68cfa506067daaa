// How many were right, and what was taken for what.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/classify/room_classifier.hpp"

namespace estancia {

/// A confusion matrix. Invariant: square, one row and column a room.
struct Confusion {
  std::vector<std::string> rooms;  ///< sorted: those that are true and those that were predicted
  std::vector<std::vector<std::size_t>> counts;  ///< [truth][prediction]

  std::size_t total() const;
  double accuracy() const;          ///< share of all that is right
  double balancedAccuracy() const;  ///< mean of the rooms' own shares; rooms that are never true do not count
};

/// Throws Error when the two are not equally long, or empty.
Confusion confusionOf(const std::vector<std::string>& truth, const std::vector<std::string>& predicted);

/// The most probable room of each row; the first in order of equals.
std::vector<std::string> mostProbable(const std::vector<std::string>& rooms,
                                      const DescriptorMatrix& probabilities);

/// What a classifier makes of frames whose rooms are known; those without are left out. A room that it never
/// learned can only be wrong. Throws Error when no room is known, or as predict() does.
Confusion testRooms(const RoomClassifier& classifier, const Features& features, int threads = 0);

}  // namespace estancia
