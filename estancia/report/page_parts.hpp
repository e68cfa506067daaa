// Parts of every page: a header with counts and facts, a table of measures, cards, the images of a place.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <utility>

#include "estancia/figures/html.hpp"
#include "estancia/report/page_contents.hpp"

namespace estancia::report {

using Facts = std::vector<std::pair<std::string, std::string>>;

/// Names and values in a row; those without a value are left out.
Markup factList(const Facts& facts);

/// `counts` are numbers with their nouns, in the singular.
Markup pageHeader(const std::string& title, const std::vector<std::pair<std::size_t, std::string>>& counts,
                  const Facts& facts);

/// A <section>; empty without measures.
Markup measuresSection(const std::vector<Measure>& measures);

/// The cards of a page: of nodes, or of zones.
struct Cards {
  Markup cards;                        ///< <article>s of the largest
  Markup rows;                         ///< shorter <article>s of others; empty when there are none
  std::size_t carded = 0, listed = 0;  ///< how many have a card, how many a row
  std::size_t withheld = 0;            ///< images left out because PageImages::bytes were used up
};

/// The <section> "places": a note (`before`, what is withheld, `after`), cards, and rows folded under
/// `smaller`.
Markup placesSection(const std::string& heading, const std::string& before, const Cards& cards,
                     const std::string& after, const std::string& smaller);

/// Digests are for machines: a run of more than 16 hex digits keeps its first 12. At most 120 characters.
std::string abbreviate(const std::string& text);

struct LoadedImages {
  std::map<std::size_t, std::vector<unsigned char>> byFrame;
  std::size_t withheld = 0;  ///< left out because PageImages::bytes were used up
};

/// Loads images of every place (its frames, ascending), evenly spread; each has one before any has two.
LoadedImages loadImages(const std::vector<const std::vector<std::size_t>*>& places, const PageImages& images);

/// The loaded images of a place; empty without any. `what` begins the alternative text; `nameOf` a frame.
Markup imageGrid(const LoadedImages& images, const std::vector<std::size_t>& frames, const std::string& what,
                 const std::function<std::string(std::size_t)>& nameOf);

}  // namespace estancia::report
