// Label choice: the labels that stand for what a person writes where the name of a label belongs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/vocabulary.hpp"

namespace estancia {

struct WordGraph;

/// One label that a query means.
struct LabelMatch {
  std::size_t label = 0;
  /// Relevance: probability that a user accepts the label, in [0, 1].
  double probability = 0;
  /// Why, for people: "its description names coffee"; "" where the label has that name.
  std::string reason;
};

struct LabelMatches {
  /// Most probable first.
  std::vector<LabelMatch> labels;
  /// The words that were looked for, where some were misspelled; else "".
  std::string corrected;
};

/// Where a word graph comes from when one is needed: installedWordGraph, or nullptr for none.
using WordGraphSource = const WordGraph* (*)();

/// findLabels(), each of probability 1: what names or holds a name goes first, so that answers do not depend
/// on WordNet. Where there is none, the labels that the words mean (findLabelMatches()), if any.
LabelMatches chooseLabels(const Vocabulary& vocabulary, std::string_view words, WordGraphSource source);

/// Texts for display: "studio couch (a kind of sofa)", one a label. Labels with a reason beyond the first
/// `shown` are counted by the last text: "3 more".
std::vector<std::string> describeMatches(const Vocabulary& vocabulary, std::span<const LabelMatch> matches,
                                         std::size_t shown = 5);

}  // namespace estancia
