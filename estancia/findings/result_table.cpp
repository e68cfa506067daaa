// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/result_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string_view>

#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"

namespace estancia {
namespace {

/// Code points: the columns in a terminal, except for wide scripts.
std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7F; }, ' ');
  return text;
}

std::string escapeLatex(const std::string& text) {
  // Spelled so that every LaTeX engine knows them.
  static const std::map<std::string_view, std::string_view> spelled = {
      {"\\", "\\textbackslash{}"},
      {"{", "\\{"},
      {"}", "\\}"},
      {"$", "\\$"},
      {"&", "\\&"},
      {"#", "\\#"},
      {"%", "\\%"},
      {"_", "\\_"},
      {"^", "\\textasciicircum{}"},
      {"~", "\\textasciitilde{}"},
      {"<", "\\textless{}"},
      {">", "\\textgreater{}"},
      {"|", "\\textbar{}"},
      {"\"", "''"},
      {"[", "{[}"},  // after \\ this would start an option
      {"]", "{]}"},
      {"*", "{*}"},
      {"–", "--"},
      {"…", "\\ldots{}"},
      {"→", "$\\rightarrow$"},
      {"×", "$\\times$"},
      {"±", "$\\pm$"},
      {"²", "$^2$"},
      {"α", "$\\alpha$"},
      {"σ", "$\\sigma$"},
      {"τ", "$\\tau$"},
      {"χ", "$\\chi$"},
  };
  const std::string line = oneLine(text);
  std::string escaped;
  for (std::size_t i = 0, end = 0; i < line.size(); i = end) {
    end = i + 1;
    while (end < line.size() && (line[end] & 0xC0) == 0x80) ++end;  // one code point
    const std::string_view letter = std::string_view(line).substr(i, end - i);
    const auto found = spelled.find(letter);
    escaped += found != spelled.end() ? found->second : letter;
  }
  return escaped;
}

/// A table as lines of cells between a start, separators and an end.
struct Layout {
  std::string start, separator, end;
  std::function<std::string(const std::string&)> escape;
  std::string boldStart, boldEnd;

  std::string line(const std::vector<std::string>& cells) const {
    return start + fmt::format("{}", fmt::join(cells, separator)) + end;
  }
  std::string head(const ResultTable& table) const {
    std::vector<std::string> cells{escape(table.rowsAre)};
    for (const auto& column : table.columns) cells.push_back(escape(column.name));
    return line(cells);
  }
  std::string body(const ResultTable& table) const {
    std::vector<std::string> best;
    for (std::size_t c = 0; c < table.columns.size(); ++c) best.push_back(bestText(table, c));
    std::string lines;
    for (const auto& row : table.rows) {
      std::vector<std::string> cells{escape(row.name)};
      for (std::size_t c = 0; c < table.columns.size(); ++c) {
        const std::string text = cellText(table.columns[c], row.values[c]);
        const bool isBest = !best[c].empty() && text == best[c];
        cells.push_back(isBest ? boldStart + escape(text) + boldEnd : escape(text));
      }
      lines += line(cells);
    }
    return lines;
  }
};

}  // namespace

std::string textTable(const ResultTable& table) {
  const std::string rowsAre = io::printable(table.rowsAre);
  std::size_t first = width(rowsAre);
  for (const auto& row : table.rows) first = std::max(first, width(io::printable(row.name)));
  std::vector<std::string> lines{rowsAre + std::string(first - width(rowsAre), ' ')};
  for (const auto& row : table.rows) {
    const std::string name = io::printable(row.name);
    lines.push_back(name + std::string(first - width(name), ' '));
  }
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::vector<std::string> cells{io::printable(table.columns[c].name)};
    for (const auto& row : table.rows) cells.push_back(cellText(table.columns[c], row.values[c]));
    std::size_t widest = 9;
    for (const std::string& cell : cells) widest = std::max(widest, width(cell));
    for (std::size_t i = 0; i < cells.size(); ++i)
      lines[i] += std::string(2 + widest - width(cells[i]), ' ') + cells[i];
  }
  return fmt::format("{}\n", fmt::join(lines, "\n"));
}

std::string escapeMarkdown(const std::string& text) {
  std::string escaped;
  for (const char c : oneLine(text)) {
    if (std::string_view("\\`*_{}[]<>#|~&$").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string markdownTable(const ResultTable& table) {
  const Layout layout{"| ", " | ", " |\n", escapeMarkdown, "**", "**"};
  std::vector<std::string> alignment{"---"};
  alignment.resize(1 + table.columns.size(), "---:");
  return layout.head(table) + layout.line(alignment) + layout.body(table);
}

std::string csvTable(const ResultTable& table) {
  std::vector<std::string> cells{io::csvCell(table.rowsAre)};
  for (const auto& column : table.columns) cells.push_back(io::csvCell(column.name));
  std::string lines = fmt::format("{}\n", fmt::join(cells, ","));
  for (const auto& row : table.rows) {
    cells = {io::csvCell(row.name)};
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      const auto& value = row.values[c];
      const bool word = table.columns[c].form == ResultTable::Form::yesNo;
      cells.push_back(!value ? "" : word ? cellText(table.columns[c], value) : fmt::format("{}", *value));
    }
    lines += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return lines;
}

std::string latexTable(const ResultTable& table) {
  const Layout layout{"", " & ", " \\\\\n", escapeLatex, "\\textbf{", "}"};
  std::string text;
  for (const std::string& comment : {table.title, table.caption})
    if (!comment.empty()) text += "% " + oneLine(comment) + "\n";
  text += "\\begin{tabular}{l" + std::string(table.columns.size(), 'r') + "}\n\\hline\n";
  return text + layout.head(table) + "\\hline\n" + layout.body(table) + "\\hline\n\\end{tabular}\n";
}

std::string cellText(const ResultTable::Column& column, const std::optional<double>& value) {
  if (!value) return "–";
  if (column.form == ResultTable::Form::yesNo) return *value != 0 ? "yes" : "no";
  if (column.form == ResultTable::Form::fixed) return fmt::format("{:.{}f}", *value, column.decimals);
  if (*value >= 0 && *value < 1e-300) return "< 1e-300";  // below what a number can hold, or nearly
  return fmt::format("{:.{}e}", *value, column.decimals);
}

std::string bestText(const ResultTable& table, std::size_t c) {
  const ResultTable::Column& column = table.columns[c];
  if (column.best == ResultTable::Best::none || table.rows.size() < 2) return "";
  std::optional<double> best;
  for (const auto& row : table.rows) {
    const auto& value = row.values[c];
    if (value && (!best || (column.best == ResultTable::Best::smallest ? *value < *best : *value > *best)))
      best = value;
  }
  return best ? cellText(column, best) : "";
}

}  // namespace estancia
