// The zones of a run from above: every image a symbol where it was taken (thesis Fig. 5.6, 5.7).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "estancia/report/driven_path.hpp"
#include "estancia/report/html.hpp"
#include "estancia/report/zone_summary.hpp"

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

/// An <svg> of the driven path and the symbols of the zones, the smallest zones on top, with numbers and
/// words where there is room. `path` must not be empty.
Markup zoneFigure(const ZonesSummary& summary, const DrivenPath& path, FigureStyle style);

}  // namespace estancia::report
