// One card a place: its words, images, neighbors and visits.
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/report/html.hpp"
#include "estancia/report/image_grid.hpp"
#include "estancia/report/map_figure.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/node_zones.hpp"
#include "estancia/report/summary.hpp"

namespace estancia::report {

struct NodeCards {
  Markup cards;              ///< <article>s of the largest nodes, in order of id
  Markup rows;               ///< shorter <article>s of all others; empty when there are none
  std::size_t carded = 0;    ///< how many nodes have a full card
  std::size_t withheld = 0;  ///< images left out because page.images.bytes were used up
};

/// `zones` may be nullptr. Badges have the colors of zones where the painting is of zones, else of rooms;
/// every card carries the node's position as data-node.
NodeCards nodeCards(const MapSummary& summary, const MapPage& page, const NodeZones* zones,
                    Painting painting);

}  // namespace estancia::report
