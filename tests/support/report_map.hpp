// Maps to draw in tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "estancia/map_file/map.hpp"

namespace estancia::test {

struct SampleOptions {
  std::size_t nodes = 5, framesPerNode = 6, labels = 40;
  bool poses = true, rooms = true;
  std::string marker = {};  ///< put into every text of the map
};

/// A robot that drives a ring of places twice.
inline TopologicalMap sampleMap(const SampleOptions& options = {}) {
  std::vector<std::string> labels;
  for (std::size_t l = 0; l < options.labels; ++l)
    labels.push_back(fmt::format("word{}{}, synonym{}", l, options.marker, l));
  TopologicalMap map{
      Vocabulary(labels), "model" + options.marker, "clr" + options.marker, {}, {}, {}, {}, {}};
  const auto count = static_cast<double>(options.nodes);
  for (std::size_t n = 0; n < options.nodes; ++n) {
    Node node{
        static_cast<int>(n), options.framesPerNode + n % 3, {}, std::vector<float>(options.labels, 0.1F)};
    for (std::size_t l = 0; l < options.labels; ++l)
      node.mean.push_back(0.6F / static_cast<float>(1 + (l + 7 * n) % options.labels));
    map.nodes.push_back(node);
  }
  for (int round = 0; round < 2; ++round)
    for (std::size_t n = 0; n < options.nodes; ++n)
      for (std::size_t i = 0; i < options.framesPerNode / 2; ++i) {
        MappedFrame frame;
        const std::size_t number = map.frames.size();
        frame.name = fmt::format("frame{:04}{}.jpg", number, options.marker);
        frame.node = static_cast<int>(n);
        const double angle = 6.28 * static_cast<double>(n) / count;
        if (options.poses) frame.pose = Pose::planar(count * std::cos(angle), count * std::sin(angle), angle);
        if (options.rooms) frame.room = fmt::format("room {}{}", n % 20, options.marker);
        const bool first = number == 0, moved = i == 0 && !first;
        const double nan = std::numeric_limits<double>::quiet_NaN();
        map.decisions.push_back({number,
                                 first        ? DecisionKind::start
                                 : !moved     ? DecisionKind::join
                                 : round == 0 ? DecisionKind::createNode
                                              : DecisionKind::revisit,
                                 frame.node, first ? -1 : map.frames.back().node,
                                 first   ? nan
                                 : moved ? 0.8
                                         : 0.2,
                                 moved ? 0 : -1, moved ? 0.3 : nan, 0.5, 0.4});
        if (moved && (round == 0 || n == 0))
          map.transitions.push_back(
              {map.frames.back().node, frame.node, 1 + static_cast<std::uint64_t>(n), number});
        map.frames.push_back(frame);
      }
  return map;
}

}  // namespace estancia::test
