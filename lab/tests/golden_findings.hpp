// Golden findings: everything that an experiment found as text, compared with a file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "experiments/src/findings/findings.hpp"

namespace estancia::test {

/// Title, facts, notes and all sections: tables as Markdown, charts and matrices as numbers.
std::string textOf(const experiments::Findings& findings);

/// Expects that these are the findings in tests/experiments/goldens/NAME.txt. With ESTANCIA_WRITE_GOLDENS=1
/// in the environment the file is written instead: look at its difference before it is committed.
void expectGolden(const std::string& name, const experiments::Findings& findings);

/// How many notes hold `fact`: a name or number of the input.
std::size_t notesNaming(const experiments::Findings& findings, const std::string& fact);

}  // namespace estancia::test
