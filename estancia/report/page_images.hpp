// Images on a page: which of many, and how much room they may take.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "estancia/report/html.hpp"

namespace estancia {

/// The images a page may show.
struct PageImages {
  std::vector<std::size_t> frames;                              ///< that have an image, ascending
  std::function<std::vector<unsigned char>(std::size_t)> read;  ///< a frame's, as MapStore gives it
  std::size_t each = 4;                                         ///< at most, of one place
  std::size_t bytes = 1'800'000;  ///< all together, before they grow by a third in the page
};

class MapStore;
struct Frame;

/// The images of a map, for `frames` of the same names in another order or choice. `map` must live as long
/// as they are read. Throws Error as MapStore does.
PageImages imagesOf(const MapStore& map, const std::vector<Frame>& frames);

namespace report {

struct LoadedImages {
  std::map<std::size_t, std::vector<unsigned char>> byFrame;
  std::size_t withheld = 0;  ///< left out because PageImages::bytes were used up
};

/// Loads images of every place (its frames, ascending), evenly spread over its life; every place has one
/// before any has two.
LoadedImages loadImages(const std::vector<const std::vector<std::size_t>*>& places, const PageImages& images);

/// The loaded images of a place; empty when there is none. `what` begins the alternative text, `nameOf`
/// gives a frame's name.
Markup imageGrid(const LoadedImages& images, const std::vector<std::size_t>& frames, const std::string& what,
                 const std::function<std::string(std::size_t)>& nameOf);

}  // namespace report
}  // namespace estancia
