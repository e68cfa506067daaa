// Files of text and bytes: folder listings, beginnings, lines, words, numbers, what is wrong with JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/printable.hpp"

namespace estancia::io {

/// The regular files directly inside `folder` (symbolic links followed) whose lower-case name ends with one
/// of `suffixes` and does not start with a dot, in natural order. Throws Error when it cannot be read.
std::vector<std::filesystem::path> filesIn(const std::filesystem::path& folder,
                                           const std::vector<std::string>& suffixes);

/// The folders directly inside `folder` whose names do not start with a dot, in natural order. Throws Error
/// when it cannot be read or holds more than 100,000.
std::vector<std::filesystem::path> foldersIn(const std::filesystem::path& folder);

/// Whether the lower-case file name ends with one of `suffixes`.
bool hasSuffix(const std::filesystem::path& file, const std::vector<std::string>& suffixes);

/// Extensions of images, lower case, with the dot.
const std::vector<std::string>& imageSuffixes();

/// Natural order of names: runs of digits compare as numbers, so "img9" comes before "img10".
bool naturalLess(std::string_view a, std::string_view b);

/// The bytes of a regular file of at most `limit` bytes. Throws Error.
std::string readBytes(const std::filesystem::path& file, std::size_t limit);

/// The first bytes of a file, at most `count`; "" where it cannot be read.
std::string firstBytes(const std::filesystem::path& file, std::size_t count);

/// Whether there are bytes, and the first 4096 hold no control character but tabs, line ends and form feeds.
/// Images, maps, videos and other binary files have some.
bool isTextFile(const std::filesystem::path& file);

/// Takes the first line off `text`, without its end (LF or CR LF).
std::string_view takeLine(std::string_view& text);

/// The text without `blanks` at its ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// Lines of a text file without CR and a leading byte order mark. Throws Error, also on NUL bytes.
std::vector<std::string> readLines(const std::filesystem::path& file);

/// The words of a line, separated by blanks and tabs.
std::vector<std::string_view> wordsOf(std::string_view line);

/// The whole of `text` as a number ("nan" and "inf" included), or nothing.
std::optional<double> toNumber(std::string_view text);

using estancia::printable;
template <std::same_as<std::filesystem::path> Path>
std::string printable(const Path& path) {
  return printable(std::string_view(path.native()));
}

/// Message for an exception of nlohmann::json, without its numbers and C++ names, such as "no JSON at line 1,
/// column 41", "\"id\" is missing" or "a value is of another type".
std::string jsonProblem(const std::exception& problem);

}  // namespace estancia::io
