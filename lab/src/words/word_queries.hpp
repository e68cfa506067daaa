// Word queries: what people ask for, and the labels that they would accept for it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/vocabulary.hpp"

namespace estancia::experiments {

struct WordQuery {
  /// What sort of question it is: synonym, purpose …; any word.
  std::string kind;
  std::string text;
  /// Labels that a person would accept, ascending; at least one.
  std::vector<std::size_t> answers;
};

/// Reads a CSV `kind,query,labels` in its order. Labels are joined by `|`: a label's first synonym, `#n`, or
/// `#a-#b` with both ends; these count ImageNet's thousand classes from 0, without the class of background
/// that some models have before them. Throws Error (malformedFile) `FILE:LINE: …` when a label is unknown, a
/// name belongs to several labels, a range is wrong, a label or a query is there twice, or a cell is empty;
/// (insufficientData) when there are no queries.
std::vector<WordQuery> readWordQueries(const std::filesystem::path& file, const Vocabulary& vocabulary);

}  // namespace estancia::experiments
