// Installed WordNet: the word graph of this machine's WordNet, read once and kept.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "estancia/words/word_graph.hpp"

namespace estancia {

/// The word graph of findWordNet(); nullptr where there is no WordNet, or it cannot be read (wordNetHint()
/// says why). The first call reads it: from the file words-N.graph beside the label cache when that is of the
/// same WordNet, else from WordNet's texts (about two seconds), and writes that file. Safe to call from
/// several threads.
const WordGraph* installedWordGraph();

/// What to install, or what is wrong with what is installed; "" when installedWordGraph() has one.
std::string wordNetHint();

}  // namespace estancia
