// World store: the tables of areas and objects in a map file. Private; see readWorld().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "estancia/areas/plan_areas.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/objects/object_instance.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia {

struct ObjectEdit;

/// An image of a segment that was labeled.
struct LabeledSegment {
  std::size_t frame = 0;
  /// The segment's number in the observation of the frame.
  std::size_t segment = 0;
  /// How well it shows the thing: its pixels; less where the image cuts it.
  double quality = 0;
  /// One probability a label.
  LexicalDescriptor words = {};
};

/// The layers above the places of a map. Writes in the store's transaction.
class WorldStore {
 public:
  /// Makes the tables where they are missing and the map is written. The store must outlive it.
  WorldStore(MapStore& store, MapStore::Access access);

  /// Whether the map has tables of layers; only files of older programs have none.
  bool exists() const { return exists_; }

  // ---- writing
  /// The layers that the map is to hold, as text.
  void putLayers(const std::string& layers);
  void putZones(const Zones& zones);
  void putObservation(std::size_t frame, const Observation& observation);
  void dropObservation(std::size_t frame);
  /// Replaces all that is derived from observations. `before`: what the map holds of it, or null; then only
  /// the frames whose area has changed are written, as a day's drive has a million others.
  void putAreas(const PlannedFrames& planned, const PlannedFrames* before = nullptr);
  /// Remembers the plan when a drive begins; gives it back, without its areas, or nothing.
  void keepPlanBefore();
  std::optional<AreaPlan> planBefore() const;
  /// Areas of frames that the map does not keep.
  void forgetAreasOfMissingFrames();
  void addEdit(const AreaEdit& edit);
  void addObjectEdit(const ObjectEdit& edit);
  void putView(const LabeledSegment& view, std::span<const unsigned char> jpeg);
  /// The labeled segments of these frames of another map (sorted numbers), which are frames from `to` on.
  void copyViews(const WorldStore& from, std::span<const std::size_t> frames, std::size_t to);
  /// The labels that a detector can give to segments, by their numbers (Labeler::regionLabels()).
  void putRegionLabels(const std::vector<std::size_t>& labels);
  /// A probability for each of these labels.
  void putSegmentWords(const SegmentPlace& segment, const LexicalDescriptor& words);
  /// Replaces all objects. `objectOf`: the object of each segment; others show none.
  void putObjects(std::span<const WorldObject> objects, const std::map<SegmentPlace, int>& objectOf);

  /// The area of each object, in their order; -1 for none.
  void putObjectAreas(std::span<const int> areas);

  // ---- reading
  /// "" where none were put.
  std::string layers() const;
  /// In order of frames; stops early when `visit` returns false. Throws Error (corruptFile).
  void forEachObservation(const std::function<bool(std::size_t frame, const Observation&)>& visit) const;
  /// The frames that have one, in order.
  std::vector<std::size_t> observedFrames() const;
  /// Observation of a frame that has one. Throws Error (corruptFile).
  Observation observation(std::size_t frame) const;
  std::vector<AreaEdit> edits() const;
  /// None in maps of older programs.
  std::vector<ObjectEdit> objectEdits() const;
  /// In order of frames and segments.
  std::vector<LabeledSegment> views() const;
  /// The object of each segment that shows one; empty in maps of programs that did not keep it.
  std::map<SegmentPlace, int> objectSegments() const;
  /// None without a detector. Throws Error (corruptFile).
  std::vector<std::size_t> regionLabels() const;
  /// In order of frames and segments. Throws Error (corruptFile).
  void forEachSegmentWords(
      const std::function<void(const SegmentPlace& segment, const LexicalDescriptor& words)>& visit) const;
  /// The best view's JPEG; empty where there is none.
  std::vector<unsigned char> objectImage(int object) const;
  /// Frames that objects refer to: first, last and best, and where a known object was recognized.
  std::vector<std::size_t> objectFrames() const;
  /// Adds all layers to `world`, whose places have been read. Throws Error (corruptFile).
  void read(WorldMap& world) const;

 private:
  void putFrameAreas(const PlannedFrames& planned, const PlannedFrames* before);
  void readZones(WorldMap& world) const;
  void readAreas(WorldMap& world) const;
  void readObjects(WorldMap& world) const;
  void readObjectNames(WorldMap& world) const;

  MapStore& store_;
  bool exists_ = true;
};

/// Keeps the edit, and does it to the objects that the map holds.
void putObjectEdit(MapStore& store, const ObjectEdit& edit);

}  // namespace estancia
