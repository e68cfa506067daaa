// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/heat_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/figures/color.hpp"
#include "estancia/figures/text.hpp"

namespace estancia {

using namespace report;
namespace {

constexpr std::size_t maxPrinted = 20;  // names; with more of them the cells are too small for numbers

}  // namespace

std::string heatStyle(double t) {
  const Color color = viridis(t);
  return "background:" + color.hex() + ";color:" + color.ink();
}

Markup heatScale(const std::string& least, const std::string& most) {
  std::string colors;
  for (const Color& color : viridisStops()) colors += (colors.empty() ? "" : ",") + color.hex();
  Markup scale;
  scale.open("p", {{"class", "scale"}}).element("span", least);
  scale.element("i", {{"style", "background:linear-gradient(90deg," + colors + ")"}}, "");
  return scale.element("span", most).close();
}

Markup matrixTable(const HeatTable& matrix) {
  const std::size_t n = matrix.names.size();
  double least = INFINITY, most = -INFINITY;
  for (const double value : matrix.values) {
    if (!std::isfinite(value)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  const auto told = [&](double value) { return fmt::format("{:.{}f}", value, matrix.decimals); };

  Markup out;
  out.open("div", {{"class", "results"}}).element("h3", shorten(matrix.title, 160));
  out.open("div", {{"class", "scroll"}, {"tabindex", "0"}}).open("table", {{"class", "numbers heat"}});
  out.open("thead").open("tr").element("th", "");
  for (const std::string& name : matrix.names)
    out.open("th", {{"scope", "col"}}).element("span", shorten(name, 40)).close();
  out.close().close().open("tbody");
  for (std::size_t r = 0; r < n; ++r) {
    out.open("tr").element("th", {{"scope", "row"}}, shorten(matrix.names[r], 40));
    for (std::size_t c = 0; c < n; ++c) {
      const double value = matrix.at(r, c);
      if (!std::isfinite(value)) {
        out.element("td", {{"class", "unknown"}}, "–");
        continue;
      }
      out.element("td",
                  {{"style", heatStyle(most > least ? (value - least) / (most - least) : 0.5)},
                   {"title", fmt::format("{} · {}: {}", matrix.names[r], matrix.names[c], told(value))}},
                  n <= maxPrinted ? told(value) : "");
    }
    out.close();
  }
  out.close().close().close();
  if (most >= least) out.add(heatScale(told(least), told(most)));
  if (!matrix.caption.empty()) out.element("p", {{"class", "note"}}, shorten(matrix.caption, 800));
  return out.close();
}

}  // namespace estancia
