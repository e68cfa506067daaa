// Driven way: a way along what the robot drove, what regions cost, and where to look at an object. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core/types.hpp>
#include <utility>

#include "estancia/world_query/route_world.hpp"

namespace estancia {

/// The costs of regions that are called so. Throws Error (unknownName) where nothing has that name.
RegionCosts regionCosts(const WorldMap& world, const RegionPreferences& preferences,
                        const RouteOptions& options, WordGraphSource source = nullptr);

/// Finds the cheapest ways (Dijkstra) among the positions of the frames: from each one to the next, and,
/// where the robot came by again, across from one to the other unless a wall is between. Invariant: each
/// station is the position of one or more frames, and `costs_` and `before_` have one entry a station. Life
/// cycle: the constructor computes all ways from one place; afterwards it is only asked.
class DrivenWays {
 public:
  /// From the middle of the place `from`: its frame nearest to their mean. The world must outlive it.
  DrivenWays(const WorldMap& world, int from, const RouteOptions& options, const RegionCosts& costs = {});

  /// To that frame; infinite where the robot did not drive there, and without poses.
  double costTo(std::size_t frame) const;
  /// Nothing where costTo() is infinite.
  std::optional<DrivenWay> wayTo(std::size_t frame) const;
  /// The middle of a place, of its frames in `areas` (empty: all). Nothing where none of them has a pose.
  std::optional<std::size_t> middleOf(int node, const std::vector<int>& areas = {}) const;

 private:
  struct Station {
    cv::Point2d at;
    double height = 0;  // above the floor [m]
    std::size_t place = 0;
    int area = -1;
    std::vector<std::size_t> next = {};
    std::vector<cv::Point2d> headings = {};  // where the robot went when it was here
  };
  void addStations();
  void drive(std::size_t from, std::size_t to);
  void linkNeighbors();
  bool mayCross(const Station& from, const Station& to) const;
  bool hasWallBetween(const cv::Point2d& from, const cv::Point2d& to) const;
  void findWays(std::size_t start);
  /// Calls `visit` with the pieces of the straight line between two stations.
  template <class Visit>
  void visitPieces(const Station& from, const Station& to, const Visit& visit) const;
  double costBetween(const Station& from, const Station& to) const;

  const WorldMap& world_;
  bool bidirectional_;
  RegionCosts regions_;
  std::vector<std::optional<cv::Point2d>> positions_;
  std::vector<double> heights_;
  std::vector<std::vector<std::size_t>> framesOf_;  // frames of each place, those with a position
  std::vector<Station> stations_;
  std::vector<std::size_t> stationOf_;  // station of each frame; undefined for frames without a position
  std::optional<std::size_t> startFrame_;
  std::vector<double> costs_;
  std::vector<std::size_t> before_;  // for each station the one before it; itself where there is none
};

/// Finds view poses among the poses of the frames.
class ViewPoses {
 public:
  /// `viewAngle` [degrees]: RouteOptions::viewAngle. The world must outlive it.
  ViewPoses(const WorldMap& world, double viewAngle);

  /// The frame nearest to the object, among those that `mayUse`, with all of it in view: its middle within
  /// the view angle, itself far enough away to fit into it, and no wall between. Else the frame that shows it
  /// best; else the nearest that had its middle in view. Nothing where there is none, or without poses.
  std::optional<ViewPose> find(const WorldObject& object,
                               const std::function<bool(std::size_t frame)>& mayUse) const;

 private:
  bool wallBetween(const cv::Point2d& from, const WorldObject& object) const;
  std::optional<ViewPose> poseAt(std::size_t frame, const WorldObject& object) const;

  const WorldMap& world_;
  double viewAngle_;  // [rad]
  Floor floor_;
};

}  // namespace estancia
