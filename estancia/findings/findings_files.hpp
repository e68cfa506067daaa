// Findings files: a page, Markdown, CSV, LaTeX and SVG.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "estancia/findings/findings.hpp"

namespace estancia {

/// Writes STEM.html, the page of it all; STEM.md, the first table under the sentences; STEM.csv and STEM.tex,
/// the first table alone; STEM.svg, the first rank diagram. Where there is no table or diagram, its files are
/// not written. Throws Error when one cannot be written.
void writeFindingsFiles(const std::filesystem::path& stem, const Findings& findings);

}  // namespace estancia
