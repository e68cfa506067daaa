// Page images: the images that a page may show, and how much room they may take.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace estancia {

/// The images a page may show.
struct PageImages {
  std::vector<std::size_t> frames;                              ///< frames that have an image, ascending
  std::function<std::vector<unsigned char>(std::size_t)> read;  ///< a frame's, as MapStore gives it
  std::size_t each = 4;                                         ///< at most, of one place
  std::size_t bytes = 1'800'000;  ///< all together, before they grow by a third in the page
};

class MapStore;
struct Frame;

/// The images of a map, for `frames` of the same names in another order or choice. `map` must live as long
/// as they are read. Throws Error as MapStore does.
PageImages imagesOf(const MapStore& map, const std::vector<Frame>& frames);

}  // namespace estancia
