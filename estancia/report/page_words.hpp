// Page words: what the search box of a map's page understands beyond the labels' own names.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estancia/report/map_page.hpp"

namespace estancia::report {

/// For word_search.js: packAssociations() of page.words for the labels that this map shows (the best words of
/// its places and objects) and those that are named by the word, and WordNet's words that only serve grammar.
/// About page.wordBytes at most: rare words are left out first. null without page.words.
nlohmann::json pageWords(const MapPage& page);

}  // namespace estancia::report
