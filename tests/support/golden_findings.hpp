// Golden findings: everything that an experiment found as text, compared with a file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "estancia/findings/findings.hpp"

namespace estancia::test {

/// Title, facts, notes and all sections: tables as Markdown, charts and matrices as numbers.
std::string textOf(const Findings& findings);

/// Expects that these are the findings in `file`. With ESTANCIA_WRITE_GOLDENS=1 in the environment the file
/// is written instead: look at its difference before it is committed.
void expectGolden(const std::filesystem::path& file, const Findings& findings);

#ifdef ESTANCIA_GOLDENS
/// The file NAME.txt of the test program's own folder.
inline void expectGolden(const char* name, const Findings& findings) {
  expectGolden(std::filesystem::path(ESTANCIA_GOLDENS) / (std::string(name) + ".txt"), findings);
}
#endif

/// How many notes hold `fact`: a name or number of the input.
std::size_t notesNaming(const Findings& findings, const std::string& fact);

}  // namespace estancia::test
