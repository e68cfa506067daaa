// Orders of places: one drive mapped with its places in other orders, since one order is one draw.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "estancia/mapper/mapper.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia::experiments {

/// Numbers below `end`, the same on every machine.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : generator_(seed) {}
  std::size_t below(std::size_t end) { return generator_() % end; }
  void shuffle(std::vector<std::size_t>& items) {
    for (std::size_t i = items.size(); i-- > 1;) std::swap(items[i], items[below(i + 1)]);
  }

 private:
  std::mt19937_64 generator_;
};

/// The node of each frame of a tour, by words alone. `tour`: frame numbers in order of time.
std::vector<int> nodesOf(const DescriptorSequence& recording, const std::vector<std::size_t>& tour,
                         const MapperOptions& options = {});

/// Agreement of places and rooms, and the number of places.
struct MappedRooms {
  double vMeasure = 0, nodes = 0;
};
/// Maps the tour by words alone, and judges it by the rooms of its frames.
MappedRooms mapRooms(const DescriptorSequence& recording, const std::vector<std::size_t>& tour,
                     const MapperOptions& options = {});

/// Random orders (seeds 1, 2, …) of the stays in a room; the frames of a stay keep theirs.
std::vector<std::vector<std::size_t>> ordersOfStays(const std::vector<Frame>& frames, std::size_t orders);

}  // namespace estancia::experiments
