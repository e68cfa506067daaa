// Localization: place recognition in a map, by single frames and by a Bayes filter over the drive.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

class MappingSession;
struct LocalizerMap;

/// Motion model and evidence of the Bayes filter.
struct PlaceFilterOptions {
  /// Probability a frame to change between driving on, driving back and standing, and to be somewhere in a
  /// linked node; where the map has no poses.
  static constexpr double turnAround = 0.005, alongEdges = 0.01;
  /// Probability a frame to be anywhere.
  static constexpr double anywhere = 0.002;
  /// Weight of one frame's evidence: frames that follow each other closely err together.
  static constexpr double temper = 0.4;
  double nearDistance = 0.7;
  double nearAngle = 30;
};
/// Declares the options and their ranges.
OptionGroup declare(PlaceFilterOptions& options);

struct LocalizerOptions {
  std::size_t lookahead = 0;
  std::size_t maxImages = 50000;
  PlaceFilterOptions filter;
};
OptionGroup declare(LocalizerOptions& options);

struct Localization {
  /// Nearest node by this frame alone.
  int node = 0;
  /// Nearest stored frame (frame number of the map) by this frame alone. With the default distance, what
  /// differs between frames of the map taken near each other counts less, and a frame is as near as those
  /// around it are in the mean.
  std::size_t nearestImage = 0;
  /// Distance to that frame, of whatever scale.
  double distance = 0;
  /// Most probable node by all frames: where the robot is.
  int beliefNode = 0;
  /// The frame with the most probable view by all frames; it need not be one of beliefNode.
  std::size_t beliefImage = 0;
  /// Probability of beliefNode.
  double confidence = 0;
  /// Probability that no mapped frame was taken near, so that beliefNode is only the nearest place; unknown
  /// where the map has no poses.
  std::optional<double> unmapped;
  /// Probability that no mapped frame was taken near in any direction: less than `unmapped` where the robot
  /// looks elsewhere from a place that it knows.
  std::optional<double> unvisited;
  /// Most probable zone by all frames, and its probability; absent without setZones().
  std::optional<int> beliefZone;
  double zoneConfidence = 0;
};

class Localizer {
 public:
  /// Reads a map file. Throws Error as readMap() does, and insufficientData for an empty map.
  explicit Localizer(const std::filesystem::path& map, const LocalizerOptions& options = {});
  /// Localizes in the map that is being made, as of now; defined by the session's room.
  explicit Localizer(MappingSession& session, const LocalizerOptions& options = {});
  /// Several localizers may share a map.
  Localizer(std::shared_ptr<const LocalizerMap> map, const LocalizerOptions& options);
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;
  ~Localizer();

  const TopologicalMap& map() const;

  /// The zone (or area, or any other group) of each frame of the map, which answers then contain, too; -1:
  /// none. Throws Error (mismatch) unless there is one a frame.
  void setZones(std::vector<int> zoneOf);

  /// Takes the next frame; gives the answers that are final now, in order of frames: its own one without
  /// lookahead, none or several with it. `odometry`: the camera's pose in any fixed frame, of which only the
  /// motion since the last frame is used, and only if the frames of the map have poses. Throws Error when it
  /// is not a descriptor of the map's labels.
  std::vector<Localization> add(DescriptorView descriptor,
                                const std::optional<Pose>& odometry = std::nullopt);
  /// The answers that still wait for later frames.
  std::vector<Localization> finish();

 private:
  friend class DriveGuide;
  /// To go on later in the same map, without lookahead. Throws Error (corruptFile).
  std::string state() const;
  void restore(const std::string& state);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace estancia
