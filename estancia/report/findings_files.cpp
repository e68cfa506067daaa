#include "estancia/report/findings_files.hpp"

#include <fmt/format.h>

#include <string>
#include <variant>

#include "estancia/core/output_file.hpp"
#include "estancia/io/result_table.hpp"
#include "estancia/report/findings_page.hpp"
#include "estancia/report/rank_diagram.hpp"

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
      fmt::format("# {}\n\n{}\n\n", io::escapeMarkdown(findings.title), io::escapeMarkdown(findings.summary));
  for (const auto& [fact, value] : findings.facts)
    text += fmt::format("* {}: {}\n", io::escapeMarkdown(fact), io::escapeMarkdown(value));
  text += fmt::format("\n{}\n{}\n", io::markdownTable(table), io::escapeMarkdown(table.caption));
  for (const std::string& note : findings.notes) text += "\n" + io::escapeMarkdown(note) + "\n";
  return text;
}

}  // namespace

void writeFindingsFiles(const std::filesystem::path& stem, const Findings& findings) {
  const auto named = [&stem](const char* ending) { return std::filesystem::path(stem.string() + ending); };
  if (const auto* table = firstOf<ResultTable>(findings)) {
    writeWhole(named(".md"), markdownOf(findings, *table));
    writeWhole(named(".csv"), io::csvTable(*table));
    writeWhole(named(".tex"), io::latexTable(*table));
  }
  if (const auto* diagram = firstOf<RankDiagram>(findings))
    writeWhole(named(".svg"), renderRankDiagram(*diagram));
  writeFindingsPage(named(".html"), findings);
}

}  // namespace estancia
