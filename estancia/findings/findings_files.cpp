// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/findings_files.hpp"

#include <fmt/format.h>

#include <string>
#include <variant>

#include "estancia/core/output_file.hpp"
#include "estancia/findings/findings_page.hpp"
#include "estancia/findings/rank_diagram.hpp"
#include "estancia/findings/result_table.hpp"

namespace estancia {
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
