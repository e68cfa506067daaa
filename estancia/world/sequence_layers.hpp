// Sequence layers: labeled frames of a recorded drive → places, and above them areas and objects. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "estancia/label/label_stream.hpp"
#include "estancia/session/map_run.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_options.hpp"

namespace estancia {

/// Adds the frames to the map of a run and to its layers; sequence, labeler and run must outlive it.
class SequenceLayers {
 public:
  struct Hooks {
    /// Alters what a new map begins with (the defaults), or what a resumed one keeps.
    std::function<void(WorldOptions&)> change = {};
    /// Before the first frame; `camera`: it is to be tracked.
    std::function<void(WorldMapper&, bool camera)> started = {};
    /// Why a frame's depth cannot be read.
    std::function<void(const std::string& why)> withoutDepth = {};
  };
  /// Opens a resumed map's layers, so that a mismatch is reported at once. Throws Error as WorldMapper.
  SequenceLayers(const Sequence& sequence, Labeler& labeler, MapRun& run, Hooks hooks);

  /// Maps the next frame, with a thumbnail if wanted.
  void add(const LabeledFrame& labeled, bool thumbnail);
  /// Writes everything.
  void finish();
  /// Null before the first frame.
  const WorldMapper* mapper() const { return layers_ ? &*layers_ : nullptr; }

 private:
  void start();
  void keepCamera();
  cv::Mat imageOf(std::size_t i) const;
  cv::Mat depthOf(std::size_t i) const;

  const Sequence& sequence_;
  Labeler& labeler_;
  MapRun& run_;
  Hooks hooks_;
  std::optional<WorldMapper> layers_;
};

}  // namespace estancia
