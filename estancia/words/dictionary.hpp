// Dictionary: words of another language, and the English ones that they are looked up by.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace estancia {

/// A text file of two columns: a word or a few, a tab or a comma, and what that is in English. Case does not
/// matter; empty lines and lines that begin with # are left out; of equal words the first line counts.
class Dictionary {
 public:
  /// Throws Error: fileUnreadable; tooLarge above 64 MB; malformedFile for a line without two columns.
  explicit Dictionary(const std::filesystem::path& file);

  /// In English: the whole text where it is an entry, else word by word; unknown words stay.
  std::string translate(std::string_view text) const;

 private:
  const std::string* find(std::string_view words) const;

  std::map<std::string, std::string, std::less<>> entries_;
};

}  // namespace estancia
