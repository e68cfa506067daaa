// Live view: what the page, the API and agents see of a map that grows, and what they may change in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// A place and how probably the robot is there.
struct PlaceBelief {
  int node = -1;
  double probability = 0;
};

/// The newest frame and the results for it.
struct LiveStatus {
  /// Counts frames and everything else that changes this; 0 before the first frame.
  std::uint64_t revision = 0;
  /// Counts what has changed WorldMap: LiveView::world().
  std::uint64_t mapRevision = 0;
  /// "mapping", "localizing", "waiting" (no frames now), "ended".
  std::string state = "waiting";
  /// Current problems, as sentences.
  std::vector<std::string> troubles;
  std::string source;
  /// Frames that were mapped or localized, that were dropped because newer ones were there, and that could
  /// not be used.
  std::size_t frames = 0, dropped = 0, failed = 0;

  // ---- of the newest frame
  std::string frame;
  std::optional<double> timestamp;
  /// T_map_camera.
  std::optional<Pose> pose;
  /// The best words, best first.
  std::vector<LabelProbability> words;
  /// Where the robot is, most probable first; empty before the first frame.
  std::vector<PlaceBelief> places;
  /// The area that it is in, -1 where none is known yet, and how probably.
  int area = -1;
  double areaProbability = 0;
  /// For display; "" without an area.
  std::string areaName;
  /// Probability that it sees nothing of the map; only where it localizes.
  std::optional<double> unmapped;
  /// Why the frame went to this place, as a sentence.
  std::string decision;

  // ---- time [ms]
  /// From the frame's arrival to its place: of the newest, the median, and what 95 % stay below, of the last
  /// 1,000.
  double latency = 0, medianLatency = 0, p95Latency = 0;
  /// Median time of the network's forward pass.
  double forward = 0;
  /// Frames a second, over the last ten.
  double rate = 0;
};

/// A person's correction of a map. Areas and objects by their numbers in LiveView::world().
struct NameArea {
  int area = -1;
  /// "" takes the name away.
  std::string name;
};
struct MergeAreas {
  int area = -1, other = -1;
};
/// See splitArea(): two points of the floor [m].
struct SplitArea {
  cv::Point2d from, to;
};
struct NameObject {
  int object = -1;
  std::string name;
};
struct DeleteObject {
  int object = -1;
};
using MapEdit = std::variant<NameArea, MergeAreas, SplitArea, NameObject, DeleteObject>;

/// Thread-safe.
class LiveView {
 public:
  virtual ~LiveView() = default;
  virtual LiveStatus status() const = 0;
  /// The status when its revision is not `revision`, or when `patience` is over.
  virtual LiveStatus waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const = 0;
  /// The newest frame as a small JPEG; null where there is none.
  virtual std::shared_ptr<const std::vector<unsigned char>> image() const = 0;
  /// The map as of some seconds ago; null before there is one.
  virtual std::shared_ptr<const WorldMap> world() const = 0;
  /// Its revision is LiveStatus::mapRevision. The best image of an object of world(), a JPEG; empty where
  /// there is none.
  virtual std::vector<unsigned char> objectImage(int object) const = 0;
  /// The image of a place's middle frame, a JPEG; empty where there is none.
  virtual std::vector<unsigned char> placeImage(int node) const = 0;
  /// Differences between drives from `since` on (the last one by default) and those before, in the form of
  /// toJson(), at most a second old. Throws Error as findChanges() does.
  virtual nlohmann::ordered_json changes(const std::optional<std::size_t>& since) const = 0;
  /// Changes the map, and returns when world() has the change. `mapRevision`: of the world() that the numbers
  /// are of. Throws Error as the functions of edit_map.hpp do; mismatch where the map
  /// has changed since that revision, busy where another program writes it.
  virtual void edit(const MapEdit& edit, const std::optional<std::uint64_t>& mapRevision) = 0;
  void edit(const MapEdit& change) { edit(change, std::nullopt); }
};

}  // namespace estancia
