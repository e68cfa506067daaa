// Critical difference diagram: mean ranks, bars join methods that do not differ (Demšar, JMLR 7 (2006)).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/figures/html.hpp"
#include "estancia/findings/findings.hpp"

namespace estancia {

/// A figure of a page. The best rank is at the left; the better half of the methods is named at the left, the
/// other at the right. Long names lose their middle.
report::Markup section(const RankDiagram& diagram);

/// Renders the diagram as an SVG file for light and dark screens that needs no other files; programs that
/// know no media queries draw it dark on white.
std::string renderRankDiagram(const RankDiagram& diagram);

}  // namespace estancia
