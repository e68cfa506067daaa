// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/map.hpp"

#include <fstream>
#include <iterator>

#include "estancia/query/accuracy.hpp"
#include "estancia/session/session.hpp"
#include "fuzz/fuzz_target.hpp"
#include "fuzz/map_patches.hpp"
#include "support/sample_world.hpp"

namespace estancia::fuzz {

/// Two drives of eight frames, with all that a session keeps to go on.
static std::string mappedFile() {
  const std::filesystem::path file = fuzz::folder() / "whole.estancia";
  const TopologicalMap places = test::samplePlaces();
  auto session = MappingSession::create(file, places.vocabulary, places.model, {});
  for (int drive = 0; drive < 2; ++drive) {
    if (drive > 0) session.beginDrive({.name = "second", .fingerprint = "f"});
    for (const MappedFrame& frame : places.frames) {
      std::vector<float> words(places.vocabulary.size(), 0.02F);
      words.at(static_cast<std::size_t>(frame.node)) = 0.9F;
      session.add(frame, words, [] { return std::vector<unsigned char>{0xFF, 0xD8, 0xFF, 0xD9}; });
    }
  }
  session.finish();
  DescriptorMatrix rooms(2);
  for (std::size_t i = 0; i < session.frames(); ++i) rooms.append(std::vector<float>{0.7F, 0.3F});
  writeRoomPredictions({"rooms-1", {"kitchen", "hall"}, std::move(rooms)}, file);
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Going on with a map reads what readMap() does not.
FUZZ_TARGET(topology, session) {
  static const std::string whole = mappedFile();
  const std::filesystem::path file = patchedMap(whole, bytes);
  const TopologicalMap places = test::samplePlaces();
  auto session = MappingSession::resume(file, places.vocabulary, places.model);
  const std::vector<float> words(places.vocabulary.size(), 0.1F);
  session.add(places.frames.front(), words);
  session.finish();
}

FUZZ_TARGET(topology, map) {
  static const std::string whole = mappedFile();
  readMap(patchedMap(whole, bytes));
}

/// Pages of SQLite.
FUZZ_TARGET(topology, map_file) {
  readMap(inputFile("input.estancia", bytes));
}

FUZZ_TARGET(topology, admissible_images) {
  readAdmissibleImages(inputFile("admissible.csv", bytes));
}

}  // namespace estancia::fuzz
