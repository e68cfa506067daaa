// Segment answers: recognized objects and classes by shape, by segment. Private; see readWorld().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estancia/map_file/store.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// A known object that was looked for in a segment.
struct SegmentRecognition {
  /// Name of the known object.
  std::string name;
  /// T_camera_model where it was found.
  std::optional<Pose> pose = {};
  /// Agreement of the best pose, whether it was accepted or not.
  double confidence = 0;
};

/// Writes in the store's transaction.
class KnownStore {
 public:
  explicit KnownStore(MapStore& store) : store_(store) {}

  // ---- writing
  /// Makes missing tables. Forgets what was found by a cloud of that name with another digest.
  void begin(const std::string& name, const std::string& digest);
  void put(const SegmentPlace& place, const SegmentRecognition& recognition);
  /// Replaces the objects' poses, entry i of object i.
  void putPoses(std::span<const std::optional<KnownPose>> poses);

  // ---- reading; nothing in maps that never had known objects. Throws Error (corruptFile).
  std::multimap<SegmentPlace, SegmentRecognition> recognitions() const;
  /// Reads the known poses of `world.objects`.
  void read(WorldMap& world) const;

 private:
  bool exists() const;

  MapStore& store_;
};

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
