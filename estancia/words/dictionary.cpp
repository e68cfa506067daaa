// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/dictionary.hpp"

#include <fmt/ranges.h>

#include <fstream>

#include "estancia/core/fail.hpp"
#include "estancia/core/utf8.hpp"
#include "estancia/words/lexicon.hpp"

namespace estancia {
namespace {

constexpr std::uintmax_t maxDictionaryBytes = 64u << 20;
constexpr std::string_view byteOrderMark = "\xEF\xBB\xBF";  // UTF-8 files of Windows programs begin with it

/// Words of splitText(), joined: "La Cuisine" → "la cuisine".
std::string normalForm(std::string_view text) {
  return fmt::format("{}", fmt::join(splitText(text), " "));
}

bool isUtf8(std::string_view text) {
  while (!text.empty())
    if (!takeCodePoint(text)) return false;
  return true;
}

}  // namespace

Dictionary::Dictionary(const std::filesystem::path& path) {
  std::error_code problem;
  const std::uintmax_t bytes = std::filesystem::file_size(path, problem);
  std::ifstream file(path, std::ios::binary);
  if (problem || !file)
    fail(ErrorCode::fileUnreadable, "cannot read the dictionary {}; name a text file of two columns",
         path.string());
  if (bytes > maxDictionaryBytes)
    fail(ErrorCode::tooLarge, "{}: {} bytes are no dictionary", path.string(), bytes);
  const auto failAt = [&path](std::size_t number, const char* what) {
    fail(ErrorCode::malformedFile, "{}, line {}: {}; write a word, a tab, and the English word, in UTF-8",
         path.string(), number, what);
  };
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (number == 1 && line.starts_with(byteOrderMark)) line.erase(0, byteOrderMark.size());
    if (!isUtf8(line)) failAt(number, "it is no UTF-8 text");
    if (normalForm(line).empty() || line.front() == '#') continue;
    const std::size_t tab = line.find('\t'), at = tab == std::string::npos ? line.find(',') : tab;
    if (at == std::string::npos) failAt(number, "it has one column");
    const std::string word = normalForm(std::string_view(line).substr(0, at)),
                      english = normalForm(std::string_view(line).substr(at + 1));
    if (word.empty() || english.empty()) failAt(number, "one of its two columns is empty");
    entries_.emplace(word, english);
  }
  if (entries_.empty())
    fail(ErrorCode::insufficientData,
         "{}: a dictionary without words; write a word, a tab, and the English word a line", path.string());
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
