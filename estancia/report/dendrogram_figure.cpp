// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace estancia::report {
namespace {

constexpr std::size_t shownMerges = 60;

using Branch = DendrogramTop::Branch;

/// The twigs from left to right as the tree hangs; by a stack, as trees may be as deep as they are wide.
std::vector<std::size_t> inOrder(const std::vector<Branch>& branches) {
  std::vector<std::size_t> twigs, stack{branches.size() - 1};
  while (!stack.empty()) {
    const std::size_t at = stack.back();
    stack.pop_back();
    if (!branches[at].left) {
      twigs.push_back(at);
      continue;
    }
    stack.push_back(*branches[at].right);
    stack.push_back(*branches[at].left);
  }
  return twigs;
}

/// Where everything is: heights across, twigs down.
struct Plot {
  double left, right, top, foot;  ///< edges of the plot
  double highest;                 ///< distance at the left edge

  double x(double height) const { return right - (right - left) * std::clamp(height / highest, 0.0, 1.0); }
};

/// Rows of the twigs: those of one zone close together, zones far enough apart for their names.
std::vector<double> rowsOf(const DendrogramTop& top, double line, double& foot) {
  std::vector<double> rows(top.branches.size());
  const auto zoneOf = [&top](std::size_t i) { return top.branches[top.twigs[i]].zone; };
  for (std::size_t i = 0; i < top.twigs.size();) {
    std::size_t end = i + 1;
    while (end < top.twigs.size() && zoneOf(i) && zoneOf(end) == zoneOf(i)) ++end;
    const auto count = static_cast<double>(end - i);
    const double room = std::max(line, 0.55 * line * count + 0.3 * line);
    for (std::size_t twig = i; twig < end; ++twig)
      rows[top.twigs[twig]] = foot + room * (static_cast<double>(twig - i) + 0.5) / count;
    foot += room;
    i = end;
  }
  for (std::size_t b = 0; b < rows.size(); ++b)
    if (top.branches[b].left) rows[b] = (rows[*top.branches[b].left] + rows[*top.branches[b].right]) / 2;
  return rows;
}

void drawAxis(Markup& svg, const Plot& plot, const FigureStyle& style) {
  const double step = niceStep(plot.highest, (plot.right - plot.left) / 90);
  for (double height = 0; height <= plot.highest * 1.0001; height += step) {
    const double x = plot.x(height);
    svg.leaf("path", {{"class", "grid"}, {"d", Path().move(x, plot.top).line(x, plot.foot).str()}});
    addText(svg, "scale-text", {x, plot.foot + 1.3 * style.fontSize}, style.fontSize - 1, number(height, 6),
            "middle");
  }
}

void drawCut(Markup& svg, const Plot& plot, double cut, const FigureStyle& style) {
  const double x = plot.x(cut);
  svg.leaf("path", {{"class", "cut"}, {"d", Path().move(x, plot.top - 4).line(x, plot.foot).str()}});
  const std::string text = "cut " + significant(cut);
  const double half = 0.55 * style.fontSize * textWidth(text);
  addText(svg, "cut-text", {std::clamp(x, half + 2, style.width - half - 2), plot.top - 8}, style.fontSize,
          text, "middle");
}

/// The lines of a branch down to its parts; a twig that holds more than one item ends in a wedge.
void addLines(const DendrogramTop& top, std::size_t b, const std::vector<double>& rows, const Plot& plot,
              Path& lines, Path& wedges) {
  const Branch& branch = top.branches[b];
  const double x = plot.x(branch.height), y = rows[b];
  if (!branch.left) {
    if (branch.items > 1) wedges.move(x, y).line(plot.x(0), y - 2.5).line(plot.x(0), y + 2.5).close();
    return;
  }
  for (const std::size_t part : {*branch.left, *branch.right})
    lines.move(x, y).line(x, rows[part]).line(plot.x(top.branches[part].height), rows[part]);
}

}  // namespace

DendrogramTop topOf(const Dendrogram& dendrogram, const std::vector<int>& zoneOf, std::size_t merges) {
  const std::size_t leaves = dendrogram.leaves(), count = dendrogram.merges().size();
  const std::size_t firstShown = leaves + count - std::min(count, merges);
  // clusters below `firstShown` are drawn as twigs: which of them each item is in, from the top down
  std::vector<std::size_t> twigOf(leaves + count);
  twigOf.back() = twigOf.size() - 1;
  for (std::size_t c = leaves + count; c-- > leaves;) {
    const auto& merge = dendrogram.merges()[c - leaves];
    for (const std::size_t part : {merge.left, merge.right})
      twigOf[part] = c >= firstShown ? part : twigOf[c];
  }
  std::map<std::size_t, std::set<int>> zonesOf;  // zones of the twigs
  for (std::size_t i = 0; i < leaves; ++i) zonesOf[twigOf[i]].insert(zoneOf[i]);

  DendrogramTop top;
  std::map<std::size_t, std::size_t> positions;  // positions of clusters
  for (const auto& [cluster, zones] : zonesOf) {
    Branch twig;
    twig.items = cluster < leaves ? 1 : dendrogram.merges()[cluster - leaves].size;
    twig.height = cluster < leaves ? 0 : dendrogram.merges()[cluster - leaves].height;
    twig.zones = zones.size();
    twig.firstZone = *zones.begin();
    if (zones.size() == 1) twig.zone = twig.firstZone;
    positions[cluster] = top.branches.size();
    top.branches.push_back(twig);
  }
  for (std::size_t c = firstShown; c < leaves + count; ++c) {
    const auto& merge = dendrogram.merges()[c - leaves];
    std::size_t first = positions.at(merge.left), second = positions.at(merge.right);
    if (top.branches[second].firstZone < top.branches[first].firstZone) std::swap(first, second);
    Branch branch{first, second, merge.height, merge.size, {}, 0, top.branches[first].firstZone};
    if (top.branches[first].zone == top.branches[second].zone) branch.zone = top.branches[first].zone;
    positions[c] = top.branches.size();
    top.branches.push_back(branch);
  }
  top.twigs = inOrder(top.branches);
  return top;
}

/// The merges below one zone, in its color, with its symbol and name.
static void drawZone(Markup& svg, const ZonesSummary& summary, const DendrogramTop& top, int zone,
                     const std::vector<std::size_t>& branches, const std::vector<double>& rows,
                     const Plot& plot, const FigureStyle& style) {
  const Zones& zones = *summary.zones;
  const auto z = static_cast<std::size_t>(zone);
  const ZoneSummary& entry = summary.list[z];
  const double y = rows[branches.back()];  // its topmost merge
  Path lines, own;
  for (const std::size_t b : branches) addLines(top, b, rows, plot, lines, own);
  const Branch& whole = top.branches[branches.back()];
  lines.move(plot.x(whole.height), y).line(plot.x(std::max(whole.height, zones.cut)), y);
  summary.openMark(svg, z, "zone");
  svg.leaf("path", {{"class", "branch"}, {"d", lines.str()}, {"stroke", entry.style.fill.hex()}});
  if (!own.empty())
    svg.leaf("path", {{"class", "wedge"},
                      {"d", own.str()},
                      {"fill", entry.style.fill.hex()},
                      {"stroke", entry.style.fill.hex()}});
  const double x = plot.right + 0.9 * style.fontSize;
  svg.leaf("path", {{"class", "mark"},
                    {"d", shapePath(entry.style.shape, 0.42 * style.fontSize, {x, y})},
                    {"fill", entry.style.fill.hex()}});
  const double room = style.width - x - style.fontSize;
  const std::string text = fmt::format("{} {}", zone, style.words ? entry.name : entry.word);
  addText(svg, "name", {x + 0.8 * style.fontSize, y + 0.35 * style.fontSize}, style.fontSize,
          shortenToWidth(text, room / (1.12 * style.fontSize)));
  svg.close();
}

Markup dendrogramFigure(const ZonesSummary& summary, FigureStyle style) {
  const Zones& zones = *summary.zones;
  const DendrogramTop top = topOf(*zones.dendrogram, zones.zoneOf, shownMerges);
  const double line = 1.35 * style.fontSize, names = style.words ? 0.36 * style.width : 0.42 * style.width;
  const double highest = std::max(top.branches.back().height, 1.02 * zones.cut);
  Plot plot{18, style.width - names, 2.2 * style.fontSize, 0, highest > 0 ? highest : 1};
  plot.foot = plot.top;
  const std::vector<double> rows = rowsOf(top, line, plot.foot);
  plot.foot += 6;
  style.height = plot.foot + 3 * style.fontSize;

  Markup svg = openFigure("tree", style,
                          fmt::format("Dendrogram: the top {} of {}", top.twigs.size() - 1,
                                      counted(zones.dendrogram->merges().size(), "merge")));
  drawAxis(svg, plot, style);
  addText(svg, "scale-text", {plot.left, style.height - 0.4 * style.fontSize}, style.fontSize,
          "distance at which two become one");

  Path above, wedges;
  std::map<int, std::vector<std::size_t>> ofZone;  // branches
  for (std::size_t b = 0; b < top.branches.size(); ++b)
    if (const auto& zone = top.branches[b].zone)
      ofZone[*zone].push_back(b);
    else
      addLines(top, b, rows, plot, above, wedges);
  svg.leaf("path", {{"class", "branch"}, {"d", above.str()}});
  svg.leaf("path", {{"class", "wedge"}, {"d", wedges.str()}});
  for (const auto& [zone, branches] : ofZone) drawZone(svg, summary, top, zone, branches, rows, plot, style);
  for (const std::size_t twig : top.twigs)
    if (!top.branches[twig].zone)
      addText(svg, "scale-text", {plot.right + 0.6 * style.fontSize, rows[twig] + 0.35 * style.fontSize},
              style.fontSize,
              fmt::format("zone {} and {}", top.branches[twig].firstZone,
                          counted(top.branches[twig].zones - 1, "other")));
  drawCut(svg, plot, zones.cut, style);
  return svg.close();
}

}  // namespace estancia::report
