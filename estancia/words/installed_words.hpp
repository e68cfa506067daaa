// Installed WordNet: the word graph of this machine's WordNet, read once and kept.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estancia/words/label_search.hpp"
#include "estancia/words/word_associations.hpp"
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

/// The graph of loadInstalledWords(), which the first call reads for the whole process, or nullptr. Safe to
/// call from several threads.
const WordGraph* installedWordGraph();

/// associateWords() of the installed WordNet, kept in a file beside that of the graph: the first time for a
/// vocabulary takes some seconds. Empty where there is no WordNet.
std::vector<WordAssociation> installedAssociations(const Vocabulary& vocabulary,
                                                   Progress& progress = Progress::none());

/// The hint of loadInstalledWords(); "" when installedWordGraph() is there.
std::string wordNetHint();

/// " (the hint)" for a message where a source of words has no graph; else "".
std::string missingWordsHint(WordGraphSource source);

/// The problem of loadInstalledWords(); "" when there is none, and before anybody asked for the graph.
std::string wordNetProblem();

}  // namespace estancia
