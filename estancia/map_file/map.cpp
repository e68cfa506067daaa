// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/map.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia {

namespace fs = std::filesystem;

const Node* TopologicalMap::findNode(int id) const {
  const auto found = std::ranges::lower_bound(nodes, id, {}, &Node::id);
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
  constexpr std::array names{"start", "join", "revisit", "create-node", "localize"};
  const auto number = static_cast<std::size_t>(kind);
  if (number >= names.size()) throw Error(ErrorCode::invalidInput, "a decision of unknown kind");
  return names[number];
}

std::vector<std::size_t> bestLabels(const Node& node, std::size_t count) {
  return bestLabels(node.mean, count);
}

bool isMapFile(const fs::path& path) {
  constexpr std::string_view magic("SQLite format 3", 16);
  constexpr std::size_t idAt = 68;  // in SQLite's header, big-endian
  std::array<char, idAt + 4> header{};
  std::error_code none;
  if (fs::is_regular_file(path, none))
    std::ifstream(path, std::ios::binary).read(header.data(), header.size());
  std::int64_t id = 0;
  for (std::size_t i = idAt; i < header.size(); ++i) id = id << 8 | static_cast<unsigned char>(header[i]);
  return std::string_view(header.data(), magic.size()) == magic && id == mapApplicationId;
}

TopologicalMap readMap(const fs::path& path) {
  return MapStore::open(path, MapStore::Access::read).load();
}

std::vector<Visit> readVisits(const fs::path& path) {
  return MapStore::open(path, MapStore::Access::read).visits();
}

DescriptorSequence readMapDescriptors(const fs::path& path) {
  MapStore store = MapStore::open(path, MapStore::Access::read);
  store.beginReading();
  const TopologicalMap map = store.load();
  DescriptorSequence sequence{map.vocabulary, map.model, {}, DescriptorMatrix(map.vocabulary.size())};
  sequence.frames.assign(map.frames.begin(), map.frames.end());
  sequence.descriptors.reserve(map.frames.size());
  store.forEachDescriptor(0, [&](std::size_t, DescriptorView descriptor) {
    sequence.descriptors.append(descriptor);
    return true;
  });
  store.endReading();
  if (sequence.descriptors.size() != sequence.frames.size())
    fail(ErrorCode::corruptFile, "{}: it has {} frames but {} descriptors; map the sequence again",
         path.string(), sequence.frames.size(), sequence.descriptors.size());
  return sequence;
}

}  // namespace estancia
