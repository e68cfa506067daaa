// Words of other languages: what ask and route look up in English.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "estancia/query/ask.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia::apps {

/// Adds `--dictionary`.
void addDictionaryOption(CLI::App& command, std::string& dictionary);

/// Text that lists how words were understood: labels, each with its reason, and rooms.
std::vector<std::string> describeMeaning(const Meaning& meaning, const Vocabulary& vocabulary);

/// The words in English by a dictionary's file ("": none), unless the map has something of that name as they
/// are.
std::string inEnglish(const std::string& words, const std::string& dictionary, const WorldMap& world);

}  // namespace estancia::apps
