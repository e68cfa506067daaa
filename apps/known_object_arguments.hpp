// Known objects on the command line: `--object`, repeated, and the unit of their clouds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "estancia/recognition/object_search.hpp"

namespace estancia::apps {

struct KnownObjectArguments {
  std::vector<std::string> words;
  std::string unit = "m";
  /// Adds `--object` and `--object-unit`, and returns the former.
  CLI::Option* addTo(CLI::App& command, const std::string& help);
  std::vector<ModelFile> files() const { return modelFilesOf(words, unit); }
};

/// Adds a unit of coordinates, one of lengthUnits().
void addUnitOption(CLI::App& command, const std::string& name, std::string& unit, const std::string& help);

}  // namespace estancia::apps
