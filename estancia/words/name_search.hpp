// Name search: which name of a list (the rooms of a data set, for example) free words refer to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/words/label_search.hpp"

namespace estancia {

struct NameMatch {
  /// Index of the name.
  std::size_t name = 0;
  /// Why, for people: "by its spelling"; "" where the two differ in case, plural, hyphens or blanks at most.
  std::string reason;
  /// Whether the words misspell it.
  bool isSpelling = false;
};

/// The name that the words surely mean: the first of these rules that fits a name counts, and nothing is
/// found where it fits several. The name is equal; equal but for case, plural forms, hyphens, underscores,
/// blanks and function words ("the"); so to the words with their spelling corrected; or it has a usual
/// meaning in common with the words ("sitting room", "living_room"). The last two need WordNet, by `source`.
std::optional<NameMatch> findName(const std::vector<std::string>& names, std::string_view words,
                                  WordGraphSource source);

/// The only name that the words are a kind of: "hallway" is a kind of corridor. Nothing without WordNet.
std::optional<NameMatch> findNameOfKind(const std::vector<std::string>& names, std::string_view words,
                                        WordGraphSource source);

/// Up to three names that the words may mean where findName() is not sure: of similar spelling, or related.
std::vector<std::string> findNearNames(const std::vector<std::string>& names, std::string_view words,
                                       WordGraphSource source);

}  // namespace estancia
