// A WordNet of a few synsets, in the format of the real one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace estancia::test {

/// Content by name of a file, of all thirteen.
using WordNetTexts = std::map<std::string, std::string>;

/// Entity, animal, dog, mouse (animal and device), room, living room, kitchen, knife, stove; cook and wash;
/// hot; quickly. "mice" and "knives" are irregular.
WordNetTexts tinyWordNet();

void writeWordNet(const WordNetTexts& texts, const std::filesystem::path& folder);

}  // namespace estancia::test
