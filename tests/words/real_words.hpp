// Word graphs of tests: that of the installed WordNet, and one of a few synsets in its format.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "estancia/words/installed_words.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia::test {

inline const WordGraph& realWords() {
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) throw std::runtime_error(wordNetHint());
  return *graph;
}

/// Content by name of a file, of all thirteen.
using WordNetTexts = std::map<std::string, std::string>;

/// Entity, animal, dog, mouse (animal and device), room, living room, kitchen, knife, stove; cook and wash;
/// hot; quickly. "mice" and "knives" are irregular.
WordNetTexts tinyWordNet();

void writeWordNet(const WordNetTexts& texts, const std::filesystem::path& folder);

}  // namespace estancia::test
