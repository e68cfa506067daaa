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
/// Opinions are pooled by LogOpinionPool, which was right about places as often as the mean of the
/// probabilities and closer in its probabilities (docs/classify.md).
std::vector<std::vector<RoomProbability>> poolRooms(const RoomPredictions& predictions,
                                                    std::span<const std::size_t> groupOf, std::size_t groups);

/// "kitchen 83 %, office 10 %": the `most` likeliest, down to one percent; "" where there are none.
std::string describeRooms(const std::vector<RoomProbability>& rooms, std::size_t most = 3);

}  // namespace estancia
