// Driven way: a route as the robot drove it, point by point. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "estancia/topology/route.hpp"
#include "estancia/world/world_map.hpp"

namespace estancia {

/// Where a route goes on the floor, in the floor's axes [m].
struct DrivenWay {
  std::vector<cv::Point2d> points;
  /// [m]
  double length = 0;
};

/// Finds ways among the positions of the frames: from each one to the next, and, where the robot came by
/// again, across from one to the other unless a wall is between.
class DrivenWays {
 public:
  /// `factors`: what a meter costs in each place, in the order of map.nodes; empty: 1. The world must outlive
  /// it.
  DrivenWays(const WorldMap& world, const RouteOptions& options, std::vector<double> factors = {});

  /// From the middle of the route's first place to that frame, the shortest way; a meter outside of the
  /// route's places counts twice. Nothing without poses, or where the robot did not drive there.
  std::optional<DrivenWay> along(const Route& route, std::size_t frame) const;
  /// To the middle of the route's last place.
  std::optional<DrivenWay> along(const Route& route) const;

 private:
  struct Station {
    cv::Point2d at;
    std::size_t node = 0;
    std::vector<std::size_t> next = {};
  };
  void addStations();
  void linkNeighbors();
  bool hasWallBetween(const cv::Point2d& from, const cv::Point2d& to) const;
  /// The frame of a place that is nearest to the mean of its frames.
  std::optional<std::size_t> middleOf(int node) const;
  /// For each station the one before it on the way from `start`; itself where there is none.
  std::vector<std::size_t> waysFrom(std::size_t start, const Route& route) const;

  const WorldMap& world_;
  bool bidirectional_;
  std::vector<double> factors_;
  std::vector<std::optional<cv::Point2d>> positions_;
  std::vector<Station> stations_;
  /// Of each frame; meaningless for those without a position.
  std::vector<std::size_t> stationOf_;
};

}  // namespace estancia
