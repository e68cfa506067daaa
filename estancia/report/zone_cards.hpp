// One card a zone: its words with their spread, images, rooms, position and visits.
#pragma once

#include <cstddef>

#include "estancia/report/html.hpp"
#include "estancia/report/image_grid.hpp"
#include "estancia/report/zone_summary.hpp"

namespace estancia::report {

struct ZoneCards {
  Markup cards;                        ///< <article>s of the largest zones
  Markup rows;                         ///< shorter <article>s of the next ones; empty when there are none
  std::size_t carded = 0, listed = 0;  ///< how many have a card, how many a row
  std::size_t withheld = 0;            ///< images left out because their room was used up
};

ZoneCards zoneCards(const ZonesSummary& summary, const PageImages& images, std::size_t cards);

}  // namespace estancia::report
