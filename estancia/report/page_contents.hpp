// Page contents: the measures, images and layers that a page shows.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace estancia {

struct Frame;
class MapStore;
struct WorldMap;

/// One row of a table of measures.
struct Measure {
  std::string key;   ///< in JSON
  std::string name;  ///< for people
  std::optional<double> value;
  int decimals;
  std::string explanation;   ///< one sentence
  std::string text() const;  ///< the value, or "unknown"
};

/// The images a page may show.
struct PageImages {
  std::vector<std::size_t> frames;                              ///< frames with an image, ascending
  std::function<std::vector<unsigned char>(std::size_t)> read;  ///< a frame's, as MapStore gives it
  std::size_t each = 4;                                         ///< at most, of one place
  std::size_t bytes = 1'800'000;  ///< all together, before they grow by a third in the page
};

/// The images of a map, for `frames` of the same names in another order or choice. `map` must live as long
/// as they are read. Throws Error as MapStore does.
PageImages imagesOf(const MapStore& map, const std::vector<Frame>& frames);

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
