// When a run changes zones: a ribbon over its images.
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/report/driven_path.hpp"
#include "estancia/report/html.hpp"
#include "estancia/report/visits.hpp"
#include "estancia/report/zone_summary.hpp"

namespace estancia::report {

/// A stay in a zone.
struct Stay : Visit {
  int zone = 0;
};

/// The stays of a run (one zone a frame), at most `columns`: in longer runs the frames are taken together in
/// so many stretches, each of which counts as the zone of most of its frames.
std::vector<Stay> staysOf(const std::vector<int>& zoneOf, std::size_t columns);

/// An <svg> of style.width×style.height with the zones' colors, their numbers where there is room, and frame
/// numbers below.
Markup timeStrip(const ZonesSummary& summary, const FigureStyle& style);

}  // namespace estancia::report
