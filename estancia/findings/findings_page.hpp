// Findings page: one HTML file of an experiment, which needs no other file and no network; other files beside
// it. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "estancia/figures/html.hpp"
#include "estancia/findings/findings.hpp"

namespace estancia {

/// A figure with legend, axes and caption. A curve breaks where its value is not finite.
report::Markup section(const LineChart& chart);

/// The whole page. Texts may hold anything; they are escaped. Equal findings give equal bytes.
std::string renderFindingsPage(const Findings& findings);

/// Renders and writes the page beside `path`, then renames it. Throws Error when it cannot be written.
void writeFindingsPage(const std::filesystem::path& path, const Findings& findings);

/// Writes STEM.html, the page of it all; STEM.md, the first table under the sentences; STEM.csv and STEM.tex,
/// the first table alone; STEM.svg, the first rank diagram. Where there is no table or diagram, its files are
/// not written. Throws Error when one cannot be written.
void writeFindingsFiles(const std::filesystem::path& stem, const Findings& findings);

/// Critical difference diagram (Demšar, JMLR 7 (2006)): bars join methods that do not differ. The best rank
/// is at the left; the better half of the methods is named at the left, the other at the right. Long names
/// lose their middle.
report::Markup section(const RankDiagram& diagram);

/// Renders the diagram as an SVG file for light and dark screens that needs no other files; programs that
/// know no media queries draw it dark on white.
std::string renderRankDiagram(const RankDiagram& diagram);

}  // namespace estancia
