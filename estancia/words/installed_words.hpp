// Installed WordNet: the word graph of this machine's WordNet, read once and kept.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/words/label_choice.hpp"

namespace estancia {

struct LabelConcept;
struct WordAssociation;

struct NamingOptions {
  enum class Words {
    /// A familiar word instead of several rare ones, where WordNet is installed.
    wordNet,
    /// The labels as the network has them.
    raw
  };
  Words words = Words::wordNet;
};
OptionGroup declare(NamingOptions& options);

/// The word graph of the installed WordNet, which the first call reads for the whole process, or nullptr.
/// Safe to call from several threads.
const WordGraph* installedWordGraph();

/// associateWords() of the installed WordNet, kept in a file beside that of the graph: the first time for a
/// vocabulary takes some seconds. Empty where there is no WordNet.
std::shared_ptr<const std::vector<WordAssociation>> installedAssociations(
    const Vocabulary& vocabulary, Progress& progress = Progress::none());

/// The words that may stand for labels of a vocabulary. Empty: each label stands for itself.
using LabelConcepts = std::vector<LabelConcept>;

/// Concepts by the installed WordNet, cached for the last vocabulary; empty without WordNet and for raw
/// words. Safe to call from several threads.
std::shared_ptr<const LabelConcepts> installedConcepts(const Vocabulary& vocabulary,
                                                       const NamingOptions& options);

/// What to install, or what is wrong with what is installed; "" when installedWordGraph() is there.
std::string wordNetHint();

/// " (the hint)" for a message where a source of words has no graph; else "".
std::string missingWordsHint(WordGraphSource source);

/// Why reading the graph will take as long the next time; "" when nothing is wrong, and before anybody asked
/// for the graph.
std::string wordNetProblem();

}  // namespace estancia
