// SPDX-License-Identifier: Apache-2.0
#include "support/golden_findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "estancia/core/home.hpp"
#include "estancia/findings/result_table.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

std::string headOf(const char* kind, const std::string& title, const std::string& caption) {
  return fmt::format("\n== {}: {}\n{}{}", kind, title, caption, caption.empty() ? "" : "\n");
}

std::string textOf(const ResultTable& table) {
  std::string text = headOf("table", table.title, table.caption) + markdownTable(table);
  for (const auto& column : table.columns)
    text += fmt::format("{}{}{}", &column == &table.columns.front() ? "columns:" : "",
                        fmt::format(" {}/{}/{}", column.decimals, static_cast<int>(column.best),
                                    static_cast<int>(column.form)),
                        column.beats ? fmt::format("/beats {}", *column.beats) : "");
  return text + fmt::format("; hottest {}\n", table.hottest) + csvTable(table);
}

std::string textOf(const LineChart& chart) {
  std::string text =
      headOf("chart", chart.title, chart.caption) +
      fmt::format("{} | {}{}{}\nx: {}\n", chart.xName, chart.yName, chart.logarithmic ? ", logarithmic" : "",
                  chart.closeUp ? ", close-up" : "", fmt::join(chart.x, " "));
  for (const auto& line : chart.lines)
    text += fmt::format("{}: {}{}\n", line.name, fmt::join(line.y, " "),
                        line.mark ? fmt::format(" mark {}", *line.mark) : "");
  return text;
}

std::string textOf(const StackedBars& bars) {
  std::string text =
      headOf("bars", bars.title, bars.caption) + fmt::format("{}\n", fmt::join(bars.parts, " | "));
  for (const auto& bar : bars.bars) text += fmt::format("{}: {}\n", bar.name, fmt::join(bar.values, " "));
  return text;
}

std::string textOf(const HeatTable& heat) {
  return headOf("heat", heat.title, heat.caption) + fmt::format("{}\n{} ({} decimals)\n",
                                                                fmt::join(heat.names, " | "),
                                                                fmt::join(heat.values, " "), heat.decimals);
}

std::string textOf(const RankDiagram& ranks) {
  std::string text = headOf("ranks", ranks.title, ranks.caption);
  for (const auto& method : ranks.methods) text += fmt::format("{}: {}\n", method.name, method.meanRank);
  for (const auto& [first, last] : ranks.groups) text += fmt::format("bar {}-{}\n", first, last);
  if (ranks.criticalDifference) text += fmt::format("critical difference {}\n", *ranks.criticalDifference);
  if (ranks.control) text += fmt::format("control {}\n", *ranks.control);
  return text;
}

std::string textOf(const Images& images) {
  std::string text = headOf("images", images.title, images.caption);
  for (const auto& image : images.images) text += image.caption + "\n";
  return text;
}

std::string textOf(const WordClouds& clouds) {
  std::string text = headOf("clouds", clouds.title, clouds.caption);
  for (const auto& cloud : clouds.clouds) {
    text += cloud.name + ":";
    for (const auto& [word, weight] : cloud.words) text += fmt::format(" {} {:.6g}", word, weight);
    text += "\n";
  }
  return text;
}

}  // namespace

std::string textOf(const Findings& findings) {
  std::string text = fmt::format("{}\n{}\n", findings.title, findings.summary);
  for (const auto& [fact, value] : findings.facts) text += fmt::format("fact: {}: {}\n", fact, value);
  for (const std::string& note : findings.notes) text += fmt::format("note: {}\n", note);
  for (const auto& section : findings.sections)
    text += std::visit([](const auto& one) { return textOf(one); }, section);
  for (const Findings& part : findings.apart) text += fmt::format("\n==== {}\n{}", part.file, textOf(part));
  return text;
}

std::size_t notesNaming(const Findings& findings, const std::string& fact) {
  return static_cast<std::size_t>(std::ranges::count_if(
      findings.notes, [&](const auto& note) { return note.find(fact) != std::string::npos; }));
}

void expectGolden(const std::filesystem::path& file, const Findings& findings) {
  const std::string text = textOf(findings);
  if (!environment("ESTANCIA_WRITE_GOLDENS").empty()) writeFile(file, text);
  EXPECT_EQ(text, readFile(file)) << file;
}

}  // namespace estancia::test
