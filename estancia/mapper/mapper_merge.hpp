// Mapper merge: one mapper of those of several maps. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "estancia/mapper/mapper_impl.hpp"

namespace estancia {

/// Two places of different maps, by their ids, that look like one.
struct PlaceLink {
  int a = 0, b = 0;
  /// Distance of their means, with the scales of both maps.
  double distance = 0;
  /// Threshold of the distance.
  double threshold = 0;
  /// Words alone suffice for the decision; else the places may only look alike.
  bool isSure = false;
};

/// Compares the places of two maps, which must outlive it. Both are given the scales of the two together.
class PlaceLinker {
 public:
  PlaceLinker(Mapper::Impl& a, Mapper::Impl& b);

  /// The pairs that are nearest to each other, within τ_join. They are sure where they are within τ_revisit,
  /// and 0.8 times nearer than either is to any other place of the other map (ratio test, Lowe 2004).
  std::vector<PlaceLink> nearest() const;
  /// Compares two nodes by their ids; nothing unless within τ_join. Throws Error (corruptFile) for no place.
  std::optional<PlaceLink> between(int a, int b) const;

 private:
  const NodeBank &a_, &b_;
  double join_, revisit_;
};

/// Takes places over into a mapper in which all frames were replayed.
class MapperMerge {
 public:
  /// Estimates the scales of all frames first.
  explicit MapperMerge(Mapper::Impl& merged);

  /// Renumbering of a map: what is added to the ids of its places, where its frames are now, and which place
  /// one became a part of, by their new ids: that one is taken over already, or is the same.
  struct Renumbering {
    int firstNode = 0;
    std::function<std::size_t(std::size_t)> frame;
    std::function<int(int)> kept;
  };
  void take(const Mapper::Impl& map, const Renumbering& now);
  /// The robot is in this place; poses are those.
  void finish(int node, const std::function<std::optional<Pose>(std::size_t)>& pose);

 private:
  Mapper::Impl& merged_;
  std::map<int, std::size_t> slots_;  // by id
};

}  // namespace estancia
