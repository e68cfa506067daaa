// Figures of the zones page: the run from above (thesis Fig. 5.6, 5.7), over time, as a tree of merges with
// the cut, and as a table of rooms and zones.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/figures/driven_path.hpp"
#include "estancia/figures/floor_plan.hpp"
#include "estancia/report/zone_summary.hpp"
#include "estancia/stats/linkage.hpp"

namespace estancia::report {

/// A symbol of a drawing.
struct ZoneSymbol {
  Point at;              ///< on the page
  std::size_t zone = 0;  ///< at most ZonesSummary::styled: that one stands for all smaller zones
};

/// Symbols for images at `points` (page units; images without one are left out), of the zones `zoneOf`. At
/// most `most`: in larger runs, images of one zone that lie closest together share a symbol. Images that were
/// taken at one place spread round it, as seeds in a sunflower, `gap` apart, ordered by zone.
std::vector<ZoneSymbol> placeSymbols(const std::vector<std::optional<Point>>& points,
                                     const std::vector<std::size_t>& zoneOf, double gap, std::size_t most);

/// An <svg> of the driven path and the symbols of the zones, the smallest on top, with numbers and words
/// where there is room. `path` must not be empty; with a `plan` (nullptr: none) it must be one from above.
Markup zoneFigure(const ZonesSummary& summary, const DrivenPath& path, FigureStyle style,
                  const FloorPlan* plan = nullptr);

/// A stay in a zone.
struct Stay : VisitSpan {
  int zone = 0;
};

/// The stays of a run (one zone a frame), at most `columns`: in longer runs the frames are taken together in
/// so many stretches, each of which counts as the zone of most of its frames.
std::vector<Stay> staysOf(const std::vector<int>& zoneOf, std::size_t columns);

/// An <svg> of style.width×style.height: the zones' colors, numbers where there is room, frame numbers below.
Markup timeStrip(const ZonesSummary& summary, const FigureStyle& style);

/// The top of a dendrogram: what the last merges joined, each branch below them a single twig.
struct DendrogramTop {
  struct Branch {
    std::optional<std::size_t> left, right;  ///< positions in `branches`, before this one; none for twigs
    double height = 0;                       ///< at which its items became one; 0 for a single item
    std::size_t items = 0;
    std::optional<int> zone;  ///< zone of all its items; none when they are in several
    std::size_t zones = 0;    ///< in how many the items of a twig are
    int firstZone = 0;        ///< the smallest of their numbers
  };
  std::vector<Branch> branches;    ///< twigs first, the root last
  std::vector<std::size_t> twigs;  ///< in the order in which they are drawn: no branches cross
};

/// The last `merges` merges at most. `zoneOf` has one zone a leaf, and there is at least one. Branches of
/// smaller zone numbers come first.
DendrogramTop topOf(const Dendrogram& dendrogram, const std::vector<int>& zoneOf, std::size_t merges);

/// An <svg>: the root at the left, distance across, zones with numbers and words at the right, and the cut.
/// Its height follows from the number of twigs, not from style.height. The zones must have a dendrogram.
Markup dendrogramFigure(const ZonesSummary& summary, FigureStyle style);

/// How many images of each room are in each zone.
struct RoomCounts {
  std::vector<std::string> rooms;                ///< rooms of the same main zone together, in order of zones
  std::vector<std::vector<std::size_t>> counts;  ///< a row a room, a column a zone
};

/// Images whose room is not known are left out; empty when none is. The last column stands for all zones from
/// `columns` on, where there are so many.
RoomCounts countRooms(const Zones& zones, std::size_t columns);

/// A <table>: rooms down, zones across, each cell shaded by its share of the room's images.
Markup roomTable(const ZonesSummary& summary, const RoomCounts& counts);

}  // namespace estancia::report
