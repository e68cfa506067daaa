// How images became zones: the top of the tree of merges, with the cut.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "estancia/report/driven_path.hpp"
#include "estancia/report/html.hpp"
#include "estancia/report/zone_summary.hpp"
#include "estancia/stats/linkage.hpp"

namespace estancia::report {

/// The top of a dendrogram: what the last merges joined, each branch below them a single twig.
struct DendrogramTop {
  struct Branch {
    std::optional<std::size_t> left, right;  ///< positions in `branches`, before this one; none for twigs
    double height = 0;                       ///< at which its items became one; 0 for a single item
    std::size_t items = 0;
    std::optional<int> zone;  ///< of all its items; none when they are in several
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
/// Its height follows from the number of twigs; style.height does not matter. The zones must have a
/// dendrogram.
Markup dendrogramFigure(const ZonesSummary& summary, FigureStyle style);

}  // namespace estancia::report
