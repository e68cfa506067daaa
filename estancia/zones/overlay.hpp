// Zone overlay: zones of another grouping of the same frames, as the places of a topological map. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "estancia/zones/zones.hpp"

namespace estancia {

/// A frame of the other grouping, and which group it is in.
struct GroupedFrame {
  std::string name;
  int group = 0;
};

/// The other grouping.
struct GroupedRun {
  std::vector<GroupedFrame> frames;
  Vocabulary vocabulary;
  std::vector<float> mean;  ///< mean probability of each label over the run
};

/// Which zones a group's frames are in.
struct GroupZones {
  struct Share {
    int zone = 0;
    std::size_t frames = 0;
  };
  int group = 0;
  std::size_t frames = 0;
  std::vector<Share> shares;  ///< largest first, of equal ones the smaller id; at least one
  /// The zone of most of its frames.
  int zone() const { return shares.front().zone; }
};

/// Whether words are about as frequent in both runs; true where the vocabularies differ (incomparable).
bool areOfSameRun(const Zones& zones, const GroupedRun& run);

/// One entry a group, by number. Frames are identified by their names, which two drives may share ("frame
/// 000000" …); so runs must also be areOfSameRun(). Throws Error (mismatch) when the frames differ.
std::vector<GroupZones> overlayZones(const Zones& zones, const GroupedRun& run);

/// nullptr when there is no such group.
const GroupZones* findGroup(std::span<const GroupZones> groups, int group);

}  // namespace estancia
