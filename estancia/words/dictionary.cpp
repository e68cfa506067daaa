// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/dictionary.hpp"

#include <fmt/format.h>

#include <fstream>

#include "estancia/core/error.hpp"
#include "estancia/words/lexicon.hpp"

namespace estancia {
namespace {

constexpr std::uintmax_t maxDictionaryBytes = 64u << 20;

/// As splitText() has it, joined again: "La Cuisine" → "la cuisine".
std::string normalForm(std::string_view text) {
  std::string form;
  for (const std::string& word : splitText(text)) form += (form.empty() ? "" : " ") + word;
  return form;
}

}  // namespace

Dictionary::Dictionary(const std::filesystem::path& path) {
  std::error_code problem;
  const std::uintmax_t bytes = std::filesystem::file_size(path, problem);
  std::ifstream file(path, std::ios::binary);
  if (problem || !file)
    throw Error(ErrorCode::fileUnreadable,
                fmt::format("cannot read the dictionary {}; name a text file of two columns", path.string()));
  if (bytes > maxDictionaryBytes)
    throw Error(ErrorCode::tooLarge, fmt::format("{}: {} bytes are no dictionary", path.string(), bytes));
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (normalForm(line).empty() || line.front() == '#') continue;
    const std::size_t tab = line.find('\t'), at = tab == std::string::npos ? line.find(',') : tab;
    const std::string word = at == std::string::npos ? "" : normalForm(std::string_view(line).substr(0, at));
    const std::string english =
        at == std::string::npos ? "" : normalForm(std::string_view(line).substr(at + 1));
    if (word.empty() || english.empty())
      throw Error(ErrorCode::malformedFile,
                  fmt::format("{}, line {}: it has no two columns; write a word, a tab, and the English word",
                              path.string(), number));
    entries_.emplace(word, english);
  }
}

const std::string* Dictionary::find(std::string_view words) const {
  const auto found = entries_.find(words);
  return found == entries_.end() ? nullptr : &found->second;
}

std::string Dictionary::translate(std::string_view text) const {
  const std::string whole = normalForm(text);
  if (const std::string* english = find(whole)) return *english;
  std::string translated;
  for (const std::string& word : splitText(text)) {
    const std::string* english = find(word);
    translated += (translated.empty() ? "" : " ") + (english == nullptr ? word : *english);
  }
  return translated;
}

}  // namespace estancia
