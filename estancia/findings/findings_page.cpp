// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/findings_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "estancia/core/output_file.hpp"
#include "estancia/figures/html.hpp"
#include "estancia/figures/word_cloud.hpp"
#include "estancia/findings/heat_table.hpp"
#include "estancia/findings/line_chart.hpp"
#include "estancia/findings/rank_diagram.hpp"
#include "estancia/report/page_assets.hpp"
#include "estancia/report/page_parts.hpp"

namespace estancia {
namespace {

using namespace report;

Markup section(const ResultTable& table) {
  Markup out;
  out.open("div", {{"class", "results"}}).element("h3", shorten(table.title, 160));
  out.open("div", {{"class", "scroll"}, {"tabindex", "0"}}).open("table", {{"class", "numbers"}});
  out.open("thead").open("tr").element("th", {{"scope", "col"}}, shorten(table.rowsAre, 40));
  std::vector<std::string> best;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    out.element("th", {{"scope", "col"}}, shorten(table.columns[c].name, 60));
    best.push_back(bestText(table, c));
  }
  out.close().close().open("tbody");
  for (const auto& row : table.rows) {
    out.open("tr").element("th", {{"scope", "row"}}, shorten(row.name, 60));
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const std::string text = cellText(table.columns[c], row.values[c]);
      const bool isBest = !best[c].empty() && text == best[c];
      const auto& rival = table.columns[c].beats;
      const bool beats = rival && row.values[c] && row.values[*rival] && *row.values[c] > *row.values[*rival];
      Attributes attributes;
      if (isBest || beats)
        attributes.emplace_back("class", !beats ? "best" : isBest ? "best beats" : "beats");
      if (table.hottest > 0 && row.values[c])
        attributes.emplace_back("style", heatStyle(*row.values[c] / table.hottest));
      out.element("td", attributes, text);
    }
    out.close();
  }
  out.close().close().close();
  if (table.hottest > 0 && !table.columns.empty())
    out.add(heatScale(cellText(table.columns[0], 0.0), cellText(table.columns[0], table.hottest)));
  if (!table.caption.empty()) out.element("p", {{"class", "note"}}, shorten(table.caption, 800));
  return out.close();
}

Markup section(const StackedBars& figure) {
  Markup out;
  out.open("figure", {{"class", "chart"}}).element("h3", shorten(figure.title, 160));
  out.open("ul", {{"class", "chart-legend"}});
  for (std::size_t p = 0; p < figure.parts.size(); ++p)
    out.open("li")
        .element("i", {{"class", fmt::format("part p{}", p % 3)}}, "")
        .text(shorten(figure.parts[p], 40))
        .close();
  out.close().open("div", {{"class", "stacks"}});
  for (const auto& bar : figure.bars) {
    const double whole = std::accumulate(bar.values.begin(), bar.values.end(), 0.0);
    std::string told;
    for (std::size_t p = 0; p < bar.values.size(); ++p)
      told += fmt::format("{}{} {}", p > 0 ? ", " : "", number(bar.values[p]), figure.parts[p]);
    out.element("span", {{"class", "label"}}, shorten(bar.name, 60));
    out.open("span", {{"class", "stack"}, {"role", "img"}, {"aria-label", told}, {"title", told}});
    for (std::size_t p = 0; p < bar.values.size(); ++p)
      if (bar.values[p] > 0)
        out.element("i",
                    {{"class", fmt::format("part p{}", p % 3)},
                     {"style", fmt::format("width:{}%", number(100 * bar.values[p] / whole))}},
                    "");
    out.close();
  }
  out.close();
  if (!figure.caption.empty()) out.element("figcaption", shorten(figure.caption, 600));
  return out.close();
}

Markup section(const LineChart& chart) {
  return lineChart(chart);
}

Markup section(const HeatTable& matrix) {
  return matrixTable(matrix);
}

Markup section(const RankDiagram& diagram) {
  return rankDiagram(diagram);
}

Markup section(const Images& gallery) {
  Markup out;
  out.open("div", {{"class", "results"}}).element("h3", shorten(gallery.title, 160));
  out.open("div", {{"class", gallery.wide ? "gallery wide" : "gallery"}});
  for (const Images::Image& image : gallery.images) {
    const std::string caption = shorten(image.caption, 300);
    out.open("figure").leaf(
        "img",
        {{"src", imageUri(image.file, "the image of " + caption)}, {"alt", caption}, {"decoding", "async"}});
    out.element("figcaption", caption).close();
  }
  out.close();
  if (!gallery.caption.empty()) out.element("p", {{"class", "note"}}, shorten(gallery.caption, 800));
  return out.close();
}

Markup section(const WordClouds& clouds) {
  Markup out;
  out.open("div", {{"class", "results"}}).element("h3", shorten(clouds.title, 160));
  out.open("div", {{"class", "gallery"}});
  for (const WordClouds::Cloud& cloud : clouds.clouds) {
    std::vector<std::pair<std::string, double>> words;
    for (const auto& [word, weight] : cloud.words) words.emplace_back(shorten(word, 28), weight);
    out.open("figure").add(wordCloud(words)).element("figcaption", shorten(cloud.name, 80)).close();
  }
  out.close();
  if (!clouds.caption.empty()) out.element("p", {{"class", "note"}}, shorten(clouds.caption, 800));
  return out.close();
}

}  // namespace

std::string renderFindingsPage(const Findings& findings) {
  Markup body;
  body.open("main").open("header", {{"class", "top"}}).element("h1", shorten(findings.title, 160));
  if (!findings.summary.empty()) body.element("p", {{"class", "answer"}}, shorten(findings.summary, 2000));
  body.close();
  for (const auto& part : findings.sections) {
    body.open("section");
    std::visit([&body](const auto& what) { body.add(section(what)); }, part);
    body.close();
  }
  if (!findings.facts.empty() || !findings.notes.empty()) {
    Facts facts;
    for (const auto& [name, value] : findings.facts)
      facts.emplace_back(shorten(name, 60), shorten(value, 600));
    body.open("section").element("h2", "Circumstances").add(factList(facts));
    for (const std::string& note : findings.notes) body.element("p", {{"class", "note"}}, shorten(note, 600));
    body.close();
  }
  body.close();
  return htmlDocument(findings.title, mapPageCss + tablesCss, body, "", "");
}

void writeFindingsPage(const std::filesystem::path& path, const Findings& findings) {
  writeWhole(path, renderFindingsPage(findings));
}

}  // namespace estancia
