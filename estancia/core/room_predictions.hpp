// Room predictions: probabilities of rooms for images, and their fusion.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// Evidence of one label of an image.
struct RoomEvidence {
  std::size_t image = 0, label = 0;
  /// R numbers: what the label adds to the logarithm of each room's odds.
  std::vector<float> logOdds;
};

/// Predictions of a room classifier for images; the truth is Frame::room. Invariant: one column of
/// `probabilities` a room.
struct RoomPredictions {
  /// For people: "svm-rbf on inception-v3+gist".
  std::string classifier;
  /// R names, none empty.
  std::vector<std::string> rooms;
  /// N×R; a row adds up to 1, or is all 0 for an image without a prediction.
  DescriptorMatrix probabilities;
  /// R shares of the run's images that the probabilities take into account, > 0; empty: even ones.
  std::vector<double> prior = {};
  /// Whether they follow from the rooms' names alone, without an example: sure ones are less probable then.
  bool areByName = false;
  /// Whether the user listed these rooms: all of them occur.
  bool areListed = false;
  /// Evidence of the labels with the largest weights of each image, in order of the images; empty if unknown.
  std::vector<RoomEvidence> evidence = {};

  /// A place is taken for a room that is more probable than this: than all others together, or, by name
  /// alone, than a third; all blocks of ten images of one room that were were right on the training half of
  /// NYU Depth V2 (five rooms, commonRooms()).
  double sureProbability() const { return areByName ? 1.0 / 3 : 0.5; }
};

/// Whether the image has a prediction.
bool isPredicted(const RoomPredictions& predictions, std::size_t image);

struct RoomProbability {
  std::string room;
  double probability = 0;

  bool operator==(const RoomProbability&) const = default;
};

/// The rooms of one image, best first; empty without a prediction.
std::vector<RoomProbability> rankedRooms(const RoomPredictions& predictions, std::size_t image);

/// The rooms of each group of images, best first; empty for a group without predictions. `groupOf[i]` is the
/// group of image i; images beyond its end and numbers of `groups` or more belong to none.
///
/// Predictions are fused by LogOpinionPool, without their prior: a place is no more likely to be a kitchen
/// because most images are of kitchens. The pool was as accurate on places as the mean of the probabilities
/// and better calibrated (docs/how-to/rooms.md).
std::vector<std::vector<RoomProbability>> poolRooms(const RoomPredictions& predictions,
                                                    std::span<const std::size_t> groupOf, std::size_t groups);

/// Criterion by which images are grouped.
enum class GroupedBy {
  /// What they show: places, zones.
  labels,
  /// Something else, as where they were taken: areas.
  space
};

/// Whether each group of poolRooms() surely is its best room: whether that is more probable than
/// sureProbability(), and does not rest on one label of `evidence`. A network that takes one thing for
/// another does so in all images of a place; so one label, however often it is seen, is one witness (a
/// jackknife over labels: Tukey 1958). Whichever is left out, the room has to stay more than twice as
/// probable as by chance; in groups by labels, which gather the same mistake, it has to stay the best one.
/// Predictions without evidence are judged by their probability alone.
std::vector<bool> areSureRooms(const RoomPredictions& predictions, std::span<const std::size_t> groupOf,
                               const std::vector<std::vector<RoomProbability>>& pooled, GroupedBy by);

/// "kitchen 83 %, office 10 %": the first `maxRooms`, down to one percent; "" without any.
std::string describeRooms(const std::vector<RoomProbability>& rooms, std::size_t maxRooms = 3);

}  // namespace estancia
