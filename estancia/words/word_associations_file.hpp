// Word associations file: associations as bytes, so that they are found once for each list of labels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/words/word_associations.hpp"

namespace estancia {

/// `source` identifies the words and labels.
std::string packAssociationsFile(const std::vector<WordAssociation>& associations, std::string_view source);

/// Throws Error (malformedFile, truncatedFile, corruptFile, unsupportedFile) unless packAssociationsFile() of
/// this version wrote `bytes` from the same `source`, for `labels` labels. `name` stands in the message.
std::vector<WordAssociation> unpackAssociationsFile(std::string_view bytes, std::string_view source,
                                                    std::size_t labels, const std::string& name);

}  // namespace estancia
