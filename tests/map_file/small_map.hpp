// A map file of three labels and one node, and what is done to it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/map_file/store.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {

inline MapStore::Identity identity() {
  return {Vocabulary({"cup, mug", "desk", "umbrella"}), "model-1", R"({"distance":"hellinger"})"};
}

inline LexicalDescriptor descriptorOf(std::size_t frame) {
  return {static_cast<float>(frame % 7) / 7, 0.25F, static_cast<float>(frame % 3) / 4};
}

inline MappedFrame frameNamed(std::size_t number, const std::string& name, int node = 0) {
  MappedFrame frame;
  frame.number = number;
  frame.name = name;
  frame.node = node;
  return frame;
}

/// Frames first … last − 1, all in node 0.
inline void addFrames(MapStore& store, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    store.addFrame(frameNamed(i, "frame " + std::to_string(i)), descriptorOf(i));
    store.putDecision({i, i == 0 ? DecisionKind::start : DecisionKind::join, 0, i == 0 ? -1 : 0, 0.1, -1,
                       std::nan(""), 0.3, 0.2});
  }
  store.putNode({0, last, {0.1F, 0.2F, 0.3F}, {0, 0, 0.05F}}, "memory of node 0");
}

inline Caught refusal(const std::filesystem::path& path, MapStore::Access access = MapStore::Access::read) {
  return caught([&] { MapStore::open(path, access).load(); });
}

inline std::vector<std::string> filesIn(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename());
  return names;
}

inline std::filesystem::path smallMap(const ScratchFolder& folder, std::size_t frames = 3) {
  const std::filesystem::path path = folder / "map.estancia";
  MapStore store = MapStore::create(path, identity());
  addFrames(store, 0, frames);
  store.commit();
  return path;
}

/// Changes a map as a hostile or careless program might.
inline void tamper(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
  sqlite3_close(database);
}

}  // namespace estancia::test
