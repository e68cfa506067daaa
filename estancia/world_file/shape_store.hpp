// Shape store: answers of an object model for the segments of a map. Private; see readWorld().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "estancia/map_file/store.hpp"
#include "estancia/objects/object_instance.hpp"

namespace estancia {

/// Writes in the store's transaction.
class ShapeStore {
 public:
  explicit ShapeStore(MapStore& store) : store_(store) {}

  /// Makes the tables where they are missing. Drops answers of a model with other classes or another digest.
  void begin(const std::vector<std::string>& classes, const std::string& digest);
  /// One probability a class; empty for a segment that has no answer.
  void put(const SegmentPlace& place, const std::vector<float>& probabilities);

  // ---- reading; nothing in maps that never had a model. Throws Error (corruptFile).
  std::vector<std::string> classes() const;
  /// Probabilities as stored by put().
  std::map<SegmentPlace, std::vector<float>> probabilities() const;

 private:
  MapStore& store_;
};

}  // namespace estancia
