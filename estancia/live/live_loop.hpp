// Live loop: a camera's frames become a map, or are found in one, while they come.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "estancia/live/live_view.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/sources/frame_source.hpp"

namespace estancia {

class Labeler;
struct MapBudget;
struct MapperOptions;
struct WorldOptions;

struct LiveOptions {
  /// Only finds the frames in the map, which must be there.
  bool localize = false;
  /// Change the defaults for a new map; a map that is there keeps what it was made with.
  std::function<void(MapperOptions&)> changeMapper;
  std::function<void(WorldOptions&)> changeWorld;
  /// Changes the budget that the map keeps; unchanged members stay as they are.
  std::function<void(MapBudget&)> changeBudget;
  LocalizerOptions localizer;
  /// DriveStart::posesAreInMap.
  bool posesAreInMap = false;
};

/// Takes the newest frame, reports where it is, then maps what it shows; whatever came meanwhile is dropped
/// and counted. A frame that fails is dropped and reported in LiveStatus::troubles. After a crash the map
/// file holds everything up to the last second, and the next loop goes on with it.
class LiveLoop : public LiveView {
 public:
  /// Goes on with the map file, or makes it. `labeler` must outlive the loop. Throws Error as MappingSession,
  /// WorldMapper and Localizer do; invalidInput for a labeler that discovers its words, and for options that
  /// change what a map was made with (mismatch).
  LiveLoop(std::unique_ptr<FrameSource> source, Labeler& labeler, std::filesystem::path map,
           const LiveOptions& options = {});
  ~LiveLoop() override;

  /// Until the source ends, stop() is called, or the user interrupts; then writes everything. Once. `each` is
  /// called in this thread for every frame as soon as its place is known: it must be quick. Throws Error when
  /// the map can no longer be written.
  void run(const std::function<void(const LiveStatus&)>& each = {});
  /// From any thread.
  void stop();

  LiveStatus status() const override;
  LiveStatus waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const override;
  std::shared_ptr<const std::vector<unsigned char>> image() const override;
  std::shared_ptr<const WorldMap> world() const override;
  std::vector<unsigned char> objectImage(int object) const override;
  std::vector<unsigned char> placeImage(int node) const override;
  nlohmann::ordered_json changes(const std::optional<std::size_t>& since) const override;
  using LiveView::edit;
  void edit(const MapEdit& edit, const std::optional<std::uint64_t>& mapRevision) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace estancia
