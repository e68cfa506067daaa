// Maps to draw in tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "estancia/map_file/map.hpp"

namespace estancia::test {

struct SampleOptions {
  std::size_t nodes = 5, framesPerNode = 6, labels = 40;
  bool poses = true, rooms = true;
  std::string marker = {};  ///< put into every text of the map
};

/// A robot that drives a ring of places twice.
TopologicalMap sampleMap(const SampleOptions& options = {});

}  // namespace estancia::test
