// The word graph of the installed WordNet, which script/bootstrap installs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

#include "estancia/words/installed_words.hpp"
#include "estancia/words/word_graph.hpp"

namespace estancia::test {

inline const WordGraph& realWords() {
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) throw std::runtime_error(wordNetHint());
  return *graph;
}

}  // namespace estancia::test
