// Loading of words: the installed WordNet's graph, from its texts or from a file. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "estancia/words/word_graph.hpp"

namespace estancia {

struct InstalledWords {
  /// Nothing where there is no WordNet, or it cannot be read.
  std::optional<WordGraph> graph;
  /// Advice what to install, or the fault of the installed files; "" if there is a graph.
  std::string hint;
  /// Why reading it will take as long the next time; "" when nothing is wrong.
  std::string problem = {};
};

/// The word graph of findWordNet(), read from the file words-N.graph beside the label cache when that is of
/// the same WordNet, else from WordNet's texts (more than a second); then that file is written, if its folder
/// allows it.
InstalledWords loadInstalledWords();

}  // namespace estancia
