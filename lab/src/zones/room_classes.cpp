// SPDX-License-Identifier: Apache-2.0
#include "zones/room_classes.hpp"

#include <algorithm>
#include <map>

#include "estancia/core/temporal_segments.hpp"

namespace estancia::experiments {

std::vector<std::string> classesOfRuns(const std::vector<Frame>& frames,
                                       const std::vector<std::string>& rooms,
                                       const std::vector<std::string>& marks, std::size_t parts) {
  std::vector<std::string> places = rooms;
  for (std::size_t i = 0; i < marks.size(); ++i) places[i] += '\n' + marks[i];
  std::vector<std::string> classes(frames.size());
  std::map<std::string, std::size_t> counts;  // classes of each room so far
  for (const TemporalSegment& run : temporalSegments(frames, places)) {
    const std::string& room = rooms[run.first];
    if (room.empty()) continue;
    const std::size_t pieces = std::min(parts, run.size);
    std::size_t& count = counts[room];
    for (std::size_t i = 0; i < run.size; ++i)
      classes[run.first + i] = room + " " + std::to_string(count + i * pieces / run.size + 1);
    count += pieces;
  }
  return classes;
}

}  // namespace estancia::experiments
