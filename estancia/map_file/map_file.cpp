// Common operations on map files, each in one call.
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "estancia/core/fail.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia {

namespace fs = std::filesystem;

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
