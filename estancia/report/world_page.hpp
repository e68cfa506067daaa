// World page: what a map's page shows of areas and objects.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace estancia {

struct WorldMap;

/// The layers above the places, for the page of a map.
struct WorldPage {
  const WorldMap& world;  ///< must outlive the rendering
  /// The image of an object, as WorldStore::objectImage() gives it; empty where there is none.
  std::function<std::vector<unsigned char>(int object)> image = {};
  std::optional<int> from = {};  ///< the node where ways to objects start; that of the first frame
  /// Limit of all object images together, before base64 makes them a third larger.
  std::size_t bytes = 1'200'000;
};

}  // namespace estancia
