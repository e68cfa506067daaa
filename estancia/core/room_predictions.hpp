// What a room classifier says of images, as plain data; never the truth, which is Frame::room.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// Invariant: one column of `probabilities` a room.
struct RoomPredictions {
  std::string classifier;          ///< which one, for people: "svm-rbf on inception-v3+gist"
  std::vector<std::string> rooms;  ///< R names, none empty
  DescriptorMatrix probabilities;  ///< N×R; a row adds up to 1, or is all 0 where nothing was said
};

struct RoomProbability {
  std::string room;
  double probability = 0;

  bool operator==(const RoomProbability&) const = default;
};

/// What was said of one image, best first; empty where nothing was.
std::vector<RoomProbability> roomsOf(const RoomPredictions& predictions, std::size_t image);

/// The rooms that images are taken for together, best first, of each group of images; empty where nothing was
/// said of any. `groupOf[i]` is the group of image i; images beyond its end and numbers of `groups` or more
/// belong to none.
///
/// Probabilities are averaged (the linear opinion pool, or sum rule). Images of one place are taken one after
/// the other and err together: a product would count the same evidence again and again and be sure of
/// whatever it says. The mean is the share of a place's images that are expected to show the room, does not
/// change when images repeat, forgives one that is sure and wrong (Kittler et al. 1998, On combining
/// classifiers, section 3), and goes with Eq. 4.3, by which a place's words are the mean of its images'.
std::vector<std::vector<RoomProbability>> poolRooms(const RoomPredictions& predictions,
                                                    std::span<const std::size_t> groupOf, std::size_t groups);

/// "kitchen 83 %, office 10 %": the `most` likeliest, down to one percent; "" where there are none.
std::string describeRooms(const std::vector<RoomProbability>& rooms, std::size_t most = 3);

}  // namespace estancia
