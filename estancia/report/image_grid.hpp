// Image grid: the images of a place on a page.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "estancia/figures/html.hpp"
#include "estancia/report/page_contents.hpp"

namespace estancia::report {

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

}  // namespace estancia::report
