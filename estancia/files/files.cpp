// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>

#include "estancia/core/ascii.hpp"
#include "estancia/core/fail.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Position of the first digit that is no leading zero.
std::size_t skipZeros(std::string_view text, std::size_t i) {
  while (i < text.size() && text[i] == '0') ++i;
  return i;
}

/// The entries of a folder that `wanted` takes, except hidden ones, in natural order.
template <class Wanted>
std::vector<fs::path> entriesOf(const fs::path& folder, const Wanted& wanted) {
  std::error_code error;
  std::vector<fs::path> found;
  for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error))
    if (!entry->path().filename().native().starts_with('.') && wanted(*entry)) found.push_back(entry->path());
  if (error)
    fail(ErrorCode::fileUnreadable, "{}: cannot read the folder: {}", printable(folder), error.message());
  std::ranges::sort(found, [](const fs::path& a, const fs::path& b) {
    return naturalLess(a.filename().native(), b.filename().native());
  });
  return found;
}

/// Text between two markers; "" if one is missing.
std::string_view between(std::string_view text, std::string_view before, std::string_view after) {
  const std::size_t from = text.find(before);
  if (from == std::string_view::npos) return {};
  text.remove_prefix(from + before.size());
  return text.substr(0, text.find(after));
}

}  // namespace

std::vector<fs::path> filesIn(const fs::path& folder, const std::vector<std::string>& suffixes) {
  return entriesOf(folder, [&](const fs::directory_entry& entry) {
    std::error_code unreadable;  // a dangling or circular link is no file
    return hasSuffix(entry.path(), suffixes) && entry.is_regular_file(unreadable);
  });
}

std::vector<fs::path> foldersIn(const fs::path& folder) {
  constexpr std::size_t maxFolders = 100'000;
  std::size_t count = 0;
  return entriesOf(folder, [&](const fs::directory_entry& entry) {
    std::error_code unreadable;
    if (!entry.is_directory(unreadable)) return false;
    if (++count > maxFolders)
      fail(ErrorCode::tooLarge, "{}: more than {} folders", printable(folder), maxFolders);
    return true;
  });
}

bool hasSuffix(const fs::path& file, const std::vector<std::string>& suffixes) {
  const std::string name = lowerCase(file.filename().string());
  return std::ranges::any_of(suffixes, [&name](const std::string& suffix) { return name.ends_with(suffix); });
}

const std::vector<std::string>& imageSuffixes() {
  static const std::vector<std::string> suffixes = {".jpg",  ".jpeg", ".png", ".bmp", ".tif",
                                                    ".tiff", ".webp", ".pgm", ".ppm"};
  return suffixes;
}

bool naturalLess(std::string_view a, std::string_view b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (isDigit(a[i]) && isDigit(b[j])) {
      i = skipZeros(a, i);
      j = skipZeros(b, j);
      std::size_t m = i, n = j;
      while (m < a.size() && isDigit(a[m])) ++m;
      while (n < b.size() && isDigit(b[n])) ++n;
      if (m - i != n - j) return m - i < n - j;
      const int order = a.substr(i, m - i).compare(b.substr(j, n - j));
      if (order != 0) return order < 0;
      i = m;
      j = n;
    } else {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
    }
  }
  if ((i < a.size()) != (j < b.size())) return i >= a.size();
  return a < b;  // "01" and "1" are equal numbers
}

std::string readBytes(const fs::path& file, std::size_t limit) {
  std::error_code error;
  // A pipe or a device would block or never end.
  if (!fs::is_regular_file(file, error)) {
    const bool missing = !fs::exists(file, error);
    fail(missing ? ErrorCode::fileNotFound : ErrorCode::fileUnreadable, "{}: {}", printable(file),
         missing ? "no such file" : "not a file");
  }
  const auto size = fs::file_size(file, error);
  if (error || size > limit)
    fail(ErrorCode::tooLarge, "{}: {} bytes; at most {} are read", printable(file), size, limit);
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(size, '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size)))
    fail(ErrorCode::fileUnreadable, "{}: cannot be read; check its permissions", printable(file));
  return bytes;
}

std::string firstBytes(const fs::path& file, std::size_t count) {
  std::string bytes(count, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

bool isTextFile(const fs::path& file) {
  const std::string text = firstBytes(file, 4096);
  return !text.empty() && std::ranges::none_of(text, [](char c) {
    return static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\r' && c != '\t' && c != '\f';
  });
}

std::string_view takeLine(std::string_view& text) {
  const auto end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end, text.size() - 1) + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const auto begin = text.find_first_not_of(blanks);
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

std::vector<std::string> readLines(const fs::path& file) {
  const std::string bytes = readBytes(file, std::size_t{1} << 30);
  std::string_view text = bytes;
  if (text.find('\0') != std::string_view::npos)
    fail(ErrorCode::malformedFile, "{}: not a text file (it contains NUL bytes)", printable(file));
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<std::string> lines;
  while (!text.empty()) lines.emplace_back(takeLine(text));
  return lines;
}

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t i = 0;
  while ((i = line.find_first_not_of(" \t", i)) != std::string_view::npos) {
    const auto end = std::min(line.find_first_of(" \t", i), line.size());
    words.push_back(line.substr(i, end - i));
    i = end;
  }
  return words;
}

std::optional<double> toNumber(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string jsonProblem(const std::exception& problem) {
  const std::string_view what = problem.what();
  if (const auto place = between(what, "parse error at ", ":"); !place.empty())
    return fmt::format("no JSON at {}", place);
  if (const auto key = between(what, "key '", "' not found"); !key.empty())
    return fmt::format("\"{}\" is missing", printable(key));
  if (what.starts_with("[json.exception.type_error")) return "a value is of another type";
  return printable(between(what, "] ", "\n"));
}

}  // namespace estancia::io
