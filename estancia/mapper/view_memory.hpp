// View memory: single images of places, by which these are known again from another side. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/mapper/node_bank.hpp"

namespace estancia {

/// One image of a place.
struct PlaceView {
  std::size_t frame = 0;
  /// The id of its node.
  int node = 0;
  /// The last frame that it stands for.
  std::size_t lastSeen = 0;
  std::optional<Pose> pose = {};
  /// Its descriptor as the distance embeds it, and as it is compared.
  std::vector<float> embedded = {}, compared = {};
};

/// The place that an image shows again.
struct Recognition {
  int node = 0;
  double distance = 0;
  /// Threshold of the distance.
  double threshold = 0;
  bool byPose = false;
};

/// A node's mean is near to none of its images when these look into several directions; so each node keeps
/// some of them. An image shows a known place when it is
/// * within τ_view of an earlier view: as near as two images of one view;
/// * within τ_sequence of one, and so was an image before it that looked different, by another view of the
///   same node: one thing may look like another, two side by side seldom do;
/// * taken near an earlier view by the poses of both, and words do not contradict (τ_join).
///
/// Earlier views are those that were last seen before the robot saw something else: an image beyond τ_join
/// or, for poses, twice as far away as near ones are. Views whose poses lie that far away are never the same.
///
/// Invariant: views_ and bounds_ share their indexes, counts_ and largest_ count views_, and there are at
/// most max_ views. beginDrive() makes all views so far earlier ones; a sequence ends there, in forgetFrom(),
/// and with an image that resembles no earlier view.
class ViewMemory {
 public:
  ViewMemory(Distance distance, std::size_t labels, const MapperOptions& options);

  bool isOn() const { return max_ > 0; }
  /// Keeps no more from now on.
  void bound(std::size_t most, const Thresholds& thresholds);
  /// The node that `seen`, which is remembered, shows: of several `current` if it is one, else the nearest.
  std::optional<Recognition> recognize(const PlaceView& seen, int current, const Thresholds& thresholds);
  /// Keeps a view; forgets one that is most like another where there are too many.
  void keep(PlaceView view, const Thresholds& thresholds);

  /// The distance to the nearest view of the node; infinite where it has none.
  double nearestOf(int node, std::span<const float> compared) const;
  /// The view that resembles the image most of those that were there when the drive began, embedded.
  std::optional<std::span<const float>> nearestOfEarlierDrives(std::span<const float> compared) const;
  /// Whether poses prove that no view of the node was taken near `pose`.
  bool isElsewhere(int node, const std::optional<Pose>& pose) const;
  /// Whether poses prove that no views of the two nodes were taken near each other.
  bool areApart(int a, int b) const;
  void merge(int absorbed, int kept);
  /// All views of nodes with this id or a higher one; the sequence has ended.
  void forgetFrom(int node);
  /// The robot may be anywhere: all views so far are earlier ones, and the sequence has ended.
  void beginDrive(std::size_t frame);
  /// New scales.
  void rescale(const std::function<std::vector<float>(std::span<const float>)>& compared);
  /// Poses as they are known now, by frame.
  void movePoses(const std::function<std::optional<Pose>(std::size_t)>& pose);
  void clear();
  const std::vector<PlaceView>& views() const { return views_; }

  /// The frames that are needed to go on later.
  void addNeededFrames(std::vector<std::size_t>& frames) const;
  /// To go on later: all but poses and descriptors, which `view(frame, node)` gives back; a node may be -1.
  /// Throws Error (corruptFile) when the bytes are damaged.
  std::string state() const;
  void restore(const std::string& state, std::size_t frames,
               const std::function<PlaceView(std::size_t, int)>& view);

 private:
  /// An image that resembled an earlier view.
  struct Resemblance {
    PlaceView seen, known;
  };
  enum class Relation { unknown, near, between, apart };

  std::vector<double> distancesTo(std::span<const float> compared, double tauJoin) const;
  double distance(std::span<const float> a, std::span<const float> b) const;
  Relation relation(const std::optional<Pose>& a, const std::optional<Pose>& b) const;
  bool isElsewhere(const std::optional<Pose>& a, const std::optional<Pose>& b) const;
  double likeness(const PlaceView& a, const PlaceView& b, const Thresholds& thresholds) const;
  bool continues(const PlaceView& seen, const PlaceView& known, const Thresholds& thresholds);
  void setCount(int node, std::size_t views);
  void forgetOne(int node, const Thresholds& thresholds);
  void remove(std::size_t slot);

  Distance distance_;
  std::size_t labels_, max_;
  double nearDistance_, nearAngle_;
  std::size_t driveBegan_ = 0;
  bool bounded_;  ///< bounds_ can prove that a view is far
  std::vector<PlaceView> views_;
  QuantizedUpperBounds bounds_;
  /// Views of each node that has some; the nodes with most of them first, of equal ones the lowest id.
  std::map<int, std::size_t> counts_;
  std::set<std::pair<std::ptrdiff_t, int>> largest_;
  /// The unbroken run of images that resemble earlier views, those that look different.
  std::vector<Resemblance> sequence_;
};

}  // namespace estancia
