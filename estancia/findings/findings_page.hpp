// Findings page: one HTML file of an experiment, which needs no other file and no network.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "estancia/findings/findings.hpp"

namespace estancia {

/// The whole page. Texts may hold anything; they are escaped. Equal findings give equal bytes.
std::string renderFindingsPage(const Findings& findings);

/// Renders and writes the page beside `path`, then renames it. Throws Error when it cannot be written.
void writeFindingsPage(const std::filesystem::path& path, const Findings& findings);

}  // namespace estancia
