// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_choice.hpp"

#include <fmt/format.h>

#include "estancia/core/label_words.hpp"
#include "estancia/words/label_search.hpp"

namespace estancia {

LabelMatches chooseLabels(const Vocabulary& vocabulary, std::string_view words, WordGraphSource source) {
  LabelMatches chosen;
  for (const std::size_t label : findLabels(vocabulary, words)) chosen.labels.push_back({label, 1, ""});
  return chosen.labels.empty() ? findLabelMatches(vocabulary, words, source) : chosen;
}

std::vector<std::string> describeMatches(const Vocabulary& vocabulary, std::span<const LabelMatch> matches,
                                         std::size_t shown) {
  std::vector<std::string> texts;
  for (const LabelMatch& match : matches) {
    const std::string label = shortLabel(vocabulary[match.label]);
    if (match.reason.empty())
      texts.push_back(label);
    else if (texts.size() < shown)
      texts.push_back(fmt::format("{} ({})", label, match.reason));
  }
  if (texts.size() < matches.size()) texts.push_back(fmt::format("{} more", matches.size() - texts.size()));
  return texts;
}

}  // namespace estancia
