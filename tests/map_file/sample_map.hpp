// Small maps for the tests of this room.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estancia/map_file/map.hpp"

namespace estancia::test {

/// A frame at (x, y) in a room.
inline MappedFrame frameAt(const std::string& name, int node, double x, double y, const std::string& room) {
  MappedFrame frame;
  frame.name = name;
  frame.pose = Pose::planar(x, y, 0);
  frame.room = room;
  frame.node = node;
  return frame;
}

inline Node nodeWith(int id, std::uint64_t frames, std::vector<float> mean) {
  std::vector<float> sigma(mean.size(), 0.01F);
  return {id, frames, std::move(mean), std::move(sigma)};
}

/// A flat of three places, driven kitchen → hall → office → hall: nodes 0, 1, 3 (2 was absorbed by 1) at
/// x = 0, 4, 8; two frames each, hall three.
inline TopologicalMap sampleMap() {
  TopologicalMap map{
      .vocabulary = Vocabulary({"coffee mug", "cup, mug", "desk", "umbrella", "dining table, board"}),
      .model = "model-1",
      .distance = "hellinger"};
  map.nodes = {nodeWith(0, 2, {0.5F, 0.2F, 0.0F, 0.1F, 0.2F}), nodeWith(1, 3, {0.0F, 0.1F, 0.1F, 0.7F, 0.1F}),
               nodeWith(3, 2, {0.1F, 0.05F, 0.75F, 0.0F, 0.1F})};
  map.transitions = {{0, 1, 1, 2}, {1, 3, 1, 4}, {3, 1, 1, 6}};
  map.frames = {frameAt("a.jpg", 0, 0, 0, "kitchen"), frameAt("b.jpg", 0, 0, 1, "kitchen"),
                frameAt("c.jpg", 1, 4, 0, "hall"),    frameAt("d.jpg", 1, 4, 0, "hall"),
                frameAt("e.jpg", 3, 8, 0, "office"),  frameAt("f.jpg", 3, 8, 1, "office"),
                frameAt("g.jpg", 1, 4, 0, "hall")};
  for (std::size_t i = 0; i < map.frames.size(); ++i) map.frames[i].number = i;
  map.decisions = {{0, DecisionKind::start, 0, -1, 0, -1, 0, 0.3, 0.25},
                   {1, DecisionKind::join, 0, 0, 0.1, -1, 0, 0.3, 0.25},
                   {2, DecisionKind::createNode, 1, 0, 0.6, -1, 0, 0.3, 0.25},
                   {3, DecisionKind::createNode, 2, 1, 0.4, 0, 0.5, 0.3, 0.25},
                   {4, DecisionKind::createNode, 3, 2, 0.7, 1, 0.6, 0.3, 0.25},
                   {5, DecisionKind::join, 3, 3, 0.05, -1, 0, 0.3, 0.25},
                   {6, DecisionKind::revisit, 1, 3, 0.65, 1, 0.1, 0.3, 0.25}};
  map.merges = {{5, 1, 2, 0.12, 0.2}};
  return map;
}

}  // namespace estancia::test
