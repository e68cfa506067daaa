// Map quality: agreement with rooms, links and positions, and the measure of the original program.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "estancia/map_file/map.hpp"
#include "estancia/stats/clustering_agreement.hpp"

namespace estancia {

/// The metric of the thesis author's own program: 20·(A+B+C+D+E), larger is better. By the formulas of his
/// public sources (github.com/jcarlos2289/TopoMapIdolMaven: getMapMetric, getQImgDev_D), as they compute and
/// not as they were meant: D measures one image a node. Checked on his map of Cloudy 3, to the sixth digit.
///
/// A node lies where its image nearest to the median of its images' x and y was taken (the upper median of an
/// even number). X is the extent of the plan [m].
struct OriginalScore {
  /// A: mean over the nodes of 1 − (mean frames of the node's other rooms) / (frames of its main room).
  std::optional<double> roomPurity;
  /// B: (n(n−1) − 2e) / (n(n−2)) for n nodes and e links: 0 when all are linked, (n−1)/n for a tree.
  double sparseness = 0;
  /// C: 1 − (mean distance of linked nodes) / X; 1 without links.
  std::optional<double> linkCloseness;
  /// D: 1 − 2·(mean over the nodes of the distance from the mean of its images to its last image) / X.
  std::optional<double> compactness;
  /// E: 2·√(variance of the nodes' x + that of their y) / X; 0 for one node.
  std::optional<double> spread;
  /// Present when all five are; at most 100 where the map is not larger than X.
  std::optional<double> total;
};

/// Values that need rooms or poses are absent without them.
struct MapQuality {
  std::size_t nodes = 0;
  /// Number of driven transitions; each direction counts.
  std::size_t transitions = 0;
  /// Pairs of nodes with a transition in either direction.
  std::size_t links = 0;
  std::size_t frames = 0;

  std::size_t framesWithRoom = 0;

  /// Nodes as clusters of the frames whose room is known (V-measure, ARI, purity).
  std::optional<Agreement> rooms;

  /// Agreement with the rooms that the frames see, not those that the camera stood in; absent without.
  std::size_t framesWithRoomSeen = 0;
  std::optional<Agreement> roomsSeen;

  OriginalScore original;

  /// Share of the frames with a true and a predicted room where these agree, by the frame's own prediction
  /// and by that of its node. Absent when no classifier was run.
  std::optional<double> predictedRoom, predictedNodeRoom;

  /// Mean distance of posed frames to the center of their node [m].
  std::optional<double> spatialSpread;

  /// Links against the driven path. A node stands for the room most of its frames are in. Two rooms are truly
  /// linked when somewhere two consecutive frames lie one in each.
  std::size_t trueLinks = 0;
  /// Share of the map's links inside one room or between truly linked rooms.
  std::optional<double> edgePrecision;
  /// Share of the truly linked rooms with a link of the map between them.
  std::optional<double> edgeRecall;
};

/// `roomsSeen`: the room that each frame sees, "" where unknown, or none at all. `originalExtent`: X of the
/// original score [m], 31.1725 on the author's plan of KTH-IDOL2; otherwise the diagonal of the box around
/// all poses, in x and y. Throws Error: no nodes (insufficientData), not one room seen a frame (mismatch).
/// O(frames · log frames + nodes · log nodes).
MapQuality evaluate(const TopologicalMap& map, std::span<const std::string> roomsSeen = {},
                    const std::optional<double>& originalExtent = {});

}  // namespace estancia
