// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"

namespace estancia {

const Node* TopologicalMap::findNode(int id) const {
  const auto found = std::lower_bound(nodes.begin(), nodes.end(), id,
                                      [](const Node& node, int wanted) { return node.id < wanted; });
  return found != nodes.end() && found->id == id ? &*found : nullptr;
}

bool TopologicalMap::isThinned() const {
  return !frames.empty() && frames.back().number >= frames.size();
}

std::size_t TopologicalMap::indexOf(std::size_t number) const {
  if (number < frames.size() && frames[number].number == number) return number;
  const auto next = std::ranges::upper_bound(frames, number, {}, &MappedFrame::number);
  return next == frames.begin() ? 0 : static_cast<std::size_t>(next - frames.begin()) - 1;
}

std::optional<std::size_t> TopologicalMap::findFrame(std::size_t number) const {
  const std::size_t index = indexOf(number);
  return index < frames.size() && frames[index].number == number ? std::optional(index) : std::nullopt;
}

std::size_t TopologicalMap::driveOf(std::size_t frame) const {
  const auto next = std::ranges::upper_bound(drives, frame, {}, &Drive::firstFrame);
  return next == drives.begin() ? 0 : static_cast<std::size_t>(next - drives.begin()) - 1;
}

bool TopologicalMap::beginsDrive(std::size_t frame) const {
  return std::ranges::binary_search(drives, frame, {}, &Drive::firstFrame);
}

void addFrame(std::vector<Visit>& visits, int node, std::size_t frame) {
  if (visits.empty() || visits.back().node != node) visits.push_back({node, frame, frame});
  visits.back().lastFrame = frame;
}

std::vector<Visit> visitsOf(const TopologicalMap& map) {
  if (map.visits) return *map.visits;
  std::vector<Visit> visits;
  for (const MappedFrame& frame : map.frames) addFrame(visits, frame.node, frame.number);
  return visits;
}

const Node& TopologicalMap::getNode(int id) const {
  if (const Node* node = findNode(id)) return *node;
  constexpr std::size_t shown = 40;
  std::vector<int> ids;
  for (const Node& node : nodes) ids.push_back(node.id);
  const bool cut = ids.size() > shown;
  if (cut) ids.resize(shown);
  fail(ErrorCode::unknownName, "there is no node {}; the map has nodes {}{}", id, fmt::join(ids, " "),
       cut ? " …" : "");
}

std::string toString(DecisionKind kind) {
  switch (kind) {
    case DecisionKind::start:
      return "start";
    case DecisionKind::join:
      return "join";
    case DecisionKind::revisit:
      return "revisit";
    case DecisionKind::createNode:
      return "create-node";
    case DecisionKind::localize:
      return "localize";
  }
  throw Error(ErrorCode::invalidInput, "a decision of unknown kind");
}

std::vector<std::size_t> bestLabels(const Node& node, std::size_t count) {
  return bestLabels(node.mean, count);
}

}  // namespace estancia
