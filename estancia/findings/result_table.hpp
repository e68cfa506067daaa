// Result tables as text: terminal, Markdown, CSV, LaTeX.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/findings/findings.hpp"

namespace estancia {

/// Text of a cell; "–" if the value is absent.
std::string cellText(const ResultTable::Column& column, const std::optional<double>& value);

/// Text of the best cells of a column; values with equal texts are equally good. "" points out none.
std::string bestText(const ResultTable& table, std::size_t column);

// Each writes one line for the header and one per row, all ending with a newline. Names are escaped. Cells
// show cellText(); the best cells of a column are bold in Markdown and LaTeX.

/// Aligned columns for a terminal.
std::string textTable(const ResultTable& table);

/// A table of GitHub-flavored Markdown, without title and caption.
std::string markdownTable(const ResultTable& table);

/// RFC 4180; numbers with all digits, yes and no as words, absent values as empty cells.
std::string csvTable(const ResultTable& table);

/// A plain `tabular` that needs no package; title and caption precede it as comments.
std::string latexTable(const ResultTable& table);

/// Text escaped for a paragraph of Markdown.
std::string escapeMarkdown(const std::string& text);

}  // namespace estancia
