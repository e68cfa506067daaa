// Live map: where a live frame is, in a map that grows or in one that is there. Private to LiveLoop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/layers/work_time.hpp"
#include "estancia/live/live_loop.hpp"

namespace estancia {

/// Place of a frame, as in LiveStatus.
struct LivePlace {
  std::optional<Pose> pose = {};
  std::vector<PlaceBelief> places = {};
  int area = -1;
  double areaProbability = 0;
  std::optional<double> unmapped = {};
  std::string decision = {};
};

class LiveMap {
 public:
  virtual ~LiveMap() = default;
  /// Takes the next frame and its words, and reports where it is as soon as that is known. `world`: the map
  /// as it was last read, or null. `deadline`: see WorldMapper::add(). Throws Error: the frame is lost, but
  /// the next ones may be taken.
  virtual void take(const LiveFrame& live, DescriptorView words, const std::shared_ptr<const WorldMap>& world,
                    const std::function<void(const LivePlace&)>& placed, const Deadline& deadline) = 0;
  /// Between frames: does what is due. Returns whether the map file has changed.
  virtual bool refresh() = 0;
  /// `world`: what the numbers in the edit are of. Throws Error.
  virtual void edit(const MapEdit& edit, const WorldMap& world) = 0;
  /// Whether areas are called by the rooms that their words indicate, while the map grows and in finish().
  virtual bool namesRooms() const { return false; }
  /// Whether the file is gone, or no map any more: nothing can be taken, and finish() throws the reason.
  virtual bool isLost() const { return false; }
  /// Sentences about what is wrong now.
  virtual std::vector<std::string> troubles() const { return {}; }
  /// Writes everything.
  virtual void finish() {}
};

/// A map that grows: goes on with the file, or makes it. Throws Error as MappingSession and WorldMapper do.
std::unique_ptr<LiveMap> makeMappingLiveMap(FrameSource& source, Labeler& labeler,
                                            const std::filesystem::path& path, const LiveOptions& options);
/// A map that is only read, but for edits. Throws Error as Localizer does, and mismatch for another model.
std::unique_ptr<LiveMap> makeLocalizingLiveMap(Labeler& labeler, const std::filesystem::path& path,
                                               const LiveOptions& options);

}  // namespace estancia
