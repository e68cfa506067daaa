// A table of results as text for people, papers and programs.
#pragma once

#include <string>

#include "experiments/src/findings/findings.hpp"

namespace estancia::experiments {

// All of them: one line for the head and one a row, which end with a newline; names may hold anything and are
// escaped. Cells show what cellText() says, the best cells of a column stand out in Markdown and LaTeX.

/// Columns that line up in a terminal.
std::string textTable(const ResultTable& table);

/// A table of GitHub-flavored Markdown, without title and caption.
std::string markdownTable(const ResultTable& table);

/// RFC 4180; numbers in all their digits, yes and no as such, absent values as empty cells.
std::string csvTable(const ResultTable& table);

/// A plain `tabular` that needs no package; title and caption stand before it as comments.
std::string latexTable(const ResultTable& table);

/// Any text as it may stand in a paragraph of Markdown.
std::string escapeMarkdown(const std::string& text);

}  // namespace estancia::experiments
