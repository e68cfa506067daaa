// Drive guide: where a robot is in what earlier drives have mapped, while it maps a new one. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/stats/label_scale.hpp"

namespace estancia {

/// Whether the robot is in that place, and whether where the view was taken, beyond doubt.
bool isCertain(const Localization& found);
bool showsView(const Localization& found);

/// Localizes in the frames before the drive, as the map was when the drive began, evenly thinned. Its result
/// depends on these and on the frames of the drive since; both are kept in the map file, so that a resumed
/// drive is guided as an unbroken one.
///
/// Invariant: known_ (views, transitions and scale as of the beginning of the drive) never changes;
/// localizer_ holds the belief after the frames of the drive. Made when a further drive begins or its map is
/// resumed, destroyed when the drive needs no guidance any more.
class DriveGuide {
 public:
  /// Guides a drive that begins now, with these scales of labels, by at most so many of the map's frames.
  DriveGuide(const MapStore& store, const Standardization& scale, std::size_t maxFrames);
  /// Goes on with the states() of an earlier one. Throws Error (corruptFile).
  DriveGuide(const MapStore& store, const std::string& known, const std::string& state);

  struct Guess {
    /// The id of a node as of when the drive began.
    int node = 0;
    /// Pose of the map's view that shows what the robot sees, if there is one.
    std::optional<Pose> pose;
  };
  /// Takes the next frame: where the robot is, if nearly certain. `own`: its pose in any fixed frame.
  std::optional<Guess> add(DescriptorView descriptor, const std::optional<Pose>& own);

  /// The frames that it needs to go on later.
  void addNeededFrames(std::vector<std::size_t>& frames) const;
  /// Frames needed by a stored drive guide, given its known().
  static void addNeededFrames(const std::string& known, const MapStore& store,
                              std::vector<std::size_t>& frames);
  /// Serialized: the map's part, and the state of the drive so far.
  std::string known() const;
  std::string state() const { return localizer_->state(); }

 private:
  struct Known;
  static Known knownOf(const MapStore& store, const Standardization& scale, std::size_t maxFrames);
  static Known knownFrom(const std::string& bytes, const MapStore& store);
  DriveGuide(const MapStore& store, Known known);

  std::shared_ptr<const Known> known_;
  std::optional<Localizer> localizer_;
};

}  // namespace estancia
