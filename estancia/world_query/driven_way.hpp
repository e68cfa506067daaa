// Driven way: a way along what the robot drove, point by point. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "estancia/world_file/world_map.hpp"
#include "estancia/world_query/route_world.hpp"

namespace estancia {

/// Finds the cheapest ways (Dijkstra) among the positions of the frames: from each one to the next, and,
/// where the robot came by again, across from one to the other unless a wall is between.
class DrivenWays {
 public:
  /// From the middle of the place `from`: of its frames the one that is nearest to their mean. The world must
  /// outlive it.
  DrivenWays(const WorldMap& world, int from, const RouteOptions& options, const RegionCosts& costs = {});

  /// To that frame; infinite where the robot did not drive there, and without poses.
  double costTo(std::size_t frame) const;
  /// Nothing where costTo() is infinite.
  std::optional<DrivenWay> wayTo(std::size_t frame) const;
  /// The middle of a place; of its frames in `areas` only, unless that is empty. Nothing where none of them
  /// has a pose.
  std::optional<std::size_t> middleOf(int node, const std::vector<int>& areas = {}) const;

 private:
  struct Station {
    cv::Point2d at;
    /// Above the floor [m].
    double height = 0;
    std::size_t place = 0;
    int area = -1;
    std::vector<std::size_t> next = {};
    /// Where the robot went when it was here.
    std::vector<cv::Point2d> headings = {};
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
  /// Station of each frame; undefined for frames without a position.
  std::vector<std::size_t> stationOf_;
  std::optional<std::size_t> startFrame_;
  std::vector<double> costs_;
  /// For each station the one before it; itself where there is none.
  std::vector<std::size_t> before_;
};

}  // namespace estancia
