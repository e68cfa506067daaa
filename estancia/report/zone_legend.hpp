// Zone legend: zones with their symbols, words and shares (the table of thesis Fig. 5.6 and 5.7).
#pragma once

#include "estancia/report/html.hpp"
#include "estancia/report/zone_summary.hpp"

namespace estancia::report {

/// Every zone that has a style of its own, the largest first; many are folded away. Zones are links to
/// `#zone-<id>`.
Markup zoneLegend(const ZonesSummary& summary);

}  // namespace estancia::report
