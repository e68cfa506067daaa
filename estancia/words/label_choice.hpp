// Label choice: the labels that stand for what a person writes where the name of a label belongs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/words/label_search.hpp"

namespace estancia {

/// findLabels(), each of probability 1: what names or holds a name goes first, so that answers do not depend
/// on WordNet. Where there is none, the labels that the words mean (findLabelMatches()); empty where they
/// mean none.
LabelMatches chooseLabels(const Vocabulary& vocabulary, std::string_view words, WordGraphSource source);

/// Texts for display: "studio couch (a kind of sofa)", one a label. Labels with a reason beyond the first
/// `shown` are counted by the last text: "3 more".
std::vector<std::string> describeMatches(const Vocabulary& vocabulary, std::span<const LabelMatch> matches,
                                         std::size_t shown = 5);

}  // namespace estancia
