// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/findings_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/core/output_file.hpp"
#include "estancia/figures/color.hpp"
#include "estancia/figures/word_cloud.hpp"
#include "estancia/findings/result_table.hpp"
#include "estancia/report/page_assets.hpp"
#include "estancia/report/page_parts.hpp"

namespace estancia {
namespace {

using namespace report;

/// The style of a cell: its color, and ink that reads well on it in any mode. `t` in [0, 1].
std::string heatStyle(double t) {
  const Color color = viridis(t);
  return "background:" + color.hex() + ";color:" + color.ink();
}

/// The colors, between texts for the two ends.
Markup heatScale(const std::string& least, const std::string& most) {
  std::string colors;
  for (const Color& color : viridisStops()) colors += (colors.empty() ? "" : ",") + color.hex();
  Markup scale;
  scale.open("p", {{"class", "scale"}}).element("span", least);
  scale.element("i", {{"style", "background:linear-gradient(90deg," + colors + ")"}}, "");
  return scale.element("span", most).close();
}

/// The content between a title and a caption.
Markup titled(const auto& part, const Markup& content) {
  Markup out;
  out.open("div", {{"class", "results"}}).element("h3", shorten(part.title, 160)).add(content);
  if (!part.caption.empty()) out.element("p", {{"class", "note"}}, shorten(part.caption, 800));
  return out.close();
}

Markup section(const ResultTable& table) {
  Markup out;
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
  return titled(table, out);
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

/// The names and the values in the colors of viridis, from the smallest value to the largest, with a scale
/// below. Values are printed where there are at most 20 names, and shown on hovering in any case.
Markup section(const HeatTable& matrix) {
  constexpr std::size_t maxPrinted = 20;  // names; with more of them the cells are too small for numbers
  const std::size_t n = matrix.names.size();
  double least = INFINITY, most = -INFINITY;
  for (const double value : matrix.values)
    if (std::isfinite(value)) least = std::min(least, value), most = std::max(most, value);
  const auto told = [&](double value) { return fmt::format("{:.{}f}", value, matrix.decimals); };

  Markup out;
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
  return titled(matrix, out);
}

Markup section(const Images& gallery) {
  Markup out;
  out.open("div", {{"class", gallery.wide ? "gallery wide" : "gallery"}});
  for (const Images::Image& image : gallery.images) {
    const std::string caption = shorten(image.caption, 300);
    out.open("figure").leaf(
        "img",
        {{"src", imageUri(image.file, "the image of " + caption)}, {"alt", caption}, {"decoding", "async"}});
    out.element("figcaption", caption).close();
  }
  return titled(gallery, out.close());
}

Markup section(const WordClouds& clouds) {
  Markup out;
  out.open("div", {{"class", clouds.clouds.size() == 1 ? "gallery wide" : "gallery"}});
  for (const WordClouds::Cloud& cloud : clouds.clouds) {
    std::vector<std::pair<std::string, double>> words;
    for (const auto& [word, weight] : cloud.words) words.emplace_back(shorten(word, 28), weight);
    out.open("figure").add(wordCloud(words)).element("figcaption", shorten(cloud.name, 80)).close();
  }
  return titled(clouds, out.close());
}

}  // namespace

std::string renderFindingsPage(const Findings& findings) {
  Markup body;
  body.open("main").open("header", {{"class", "top"}}).element("h1", shorten(findings.title, 160));
  if (!findings.summary.empty()) body.element("p", {{"class", "answer"}}, shorten(findings.summary, 2000));
  body.close();
  for (const auto& part : findings.sections) {
    body.open("section").add(std::visit([](const auto& what) { return section(what); }, part)).close();
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

namespace {

template <class Section>
const Section* firstOf(const Findings& findings) {
  for (const auto& section : findings.sections)
    if (const auto* found = std::get_if<Section>(&section)) return found;
  return nullptr;
}

std::string markdownOf(const Findings& findings, const ResultTable& table) {
  std::string text =
      fmt::format("# {}\n\n{}\n\n", escapeMarkdown(findings.title), escapeMarkdown(findings.summary));
  for (const auto& [fact, value] : findings.facts)
    text += fmt::format("* {}: {}\n", escapeMarkdown(fact), escapeMarkdown(value));
  text += fmt::format("\n{}\n{}\n", markdownTable(table), escapeMarkdown(table.caption));
  for (const std::string& note : findings.notes) text += "\n" + escapeMarkdown(note) + "\n";
  return text;
}

}  // namespace

void writeFindingsFiles(const std::filesystem::path& stem, const Findings& findings) {
  const auto named = [&stem](const char* ending) { return std::filesystem::path(stem.string() + ending); };
  if (const auto* table = firstOf<ResultTable>(findings)) {
    writeWhole(named(".md"), markdownOf(findings, *table));
    writeWhole(named(".csv"), csvTable(*table));
    writeWhole(named(".tex"), latexTable(*table));
  }
  if (const auto* diagram = firstOf<RankDiagram>(findings))
    writeWhole(named(".svg"), renderRankDiagram(*diagram));
  writeFindingsPage(named(".html"), findings);
}

}  // namespace estancia
