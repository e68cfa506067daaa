// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/bag_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/ros/compression.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view sqliteMagic{"SQLite format 3\0", 16};
constexpr std::array<std::string_view, 3> bagExtensions{".db3", ".mcap", ".bag"};
// Max number of missing files that are named.
constexpr std::size_t maxNamed = 5;
// Larger ones list no files [bytes].
constexpr std::uintmax_t maxMetadata = std::uintmax_t{64} << 20U;

std::string trimmed(std::string text) {
  constexpr std::string_view blanks = " \t\r";
  const auto begin = text.find_first_not_of(blanks);
  if (begin == std::string::npos) return "";
  text = text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
  const bool quoted =
      text.size() > 1 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front();
  return quoted ? text.substr(1, text.size() - 2) : text;
}

/// The items of `relative_file_paths`, as rosbag2 writes them: a line each.
std::vector<std::string> listedFiles(const fs::path& metadata) {
  std::vector<std::string> files;
  std::error_code none;
  if (fs::file_size(metadata, none) > maxMetadata || none) return files;
  std::ifstream file(metadata);
  bool listing = false;
  for (std::string line; std::getline(file, line);) {
    const std::string item = trimmed(line);
    if (listing && item.starts_with("- "))
      files.push_back(trimmed(item.substr(2)));
    else
      listing = item == "relative_file_paths:";
  }
  return files;
}

BagFiles filesOf(const fs::path& folder, const std::vector<std::string>& listed) {
  BagFiles bag;
  std::vector<std::string> missing;
  for (const std::string& path : listed) {
    // Old versions wrote the folder's name before it. Nothing leads out of the folder.
    const fs::path name = fs::path(path).filename();
    std::error_code none;
    if (!name.empty() && name != "." && name != ".." && fs::is_regular_file(folder / name, none))
      bag.files.push_back(folder / name);
    else
      missing.push_back(printable(path));
  }
  if (missing.empty()) return bag;
  const std::size_t count = missing.size();
  missing.resize(std::min(count, maxNamed));
  bag.warnings.push_back(
      fmt::format("{}: {} of {} files that its metadata.yaml lists are missing, and their messages: {}{}",
                  printable(folder.string()), count, listed.size(), fmt::join(missing, ", "),
                  count > missing.size() ? " …" : ""));
  return bag;
}

/// In order of their names.
std::vector<fs::path> bagFilesBeside(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::end(at); at.increment(error)) {
    std::error_code none;
    if (!bagExtension(at->path()).empty() && at->is_regular_file(none)) files.push_back(at->path());
  }
  if (error)
    fail(ErrorCode::fileUnreadable, "{}: {}; check its permissions", printable(folder.string()),
         error.message());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::optional<BagFormat> bagFormat(const FileBytes& file) {
  std::array<std::byte, 16> bytes{};
  const std::size_t count = std::min<std::uint64_t>(bytes.size(), file.size());
  file.read(0, std::span(bytes).first(count));
  const std::string_view begin(reinterpret_cast<const char*>(bytes.data()), count);
  if (begin.starts_with(ros1Magic)) return BagFormat::ros1;
  if (begin.starts_with(mcapMagic)) return BagFormat::mcap;
  if (begin.starts_with(sqliteMagic)) return BagFormat::sqlite;
  if (isZstd(bytes)) return BagFormat::zstd;
  return std::nullopt;
}

std::string bagExtension(const fs::path& file) {
  const std::string extension = (file.extension() == ".zstd" ? file.stem() : file).extension().string();
  return std::find(bagExtensions.begin(), bagExtensions.end(), extension) == bagExtensions.end() ? ""
                                                                                                 : extension;
}

bool isBagFolder(const fs::path& folder) {
  if (!listedFiles(folder / "metadata.yaml").empty()) return true;
  bool others = false, found = false;
  std::error_code error;
  for (auto at = fs::directory_iterator(folder, error); !error && at != fs::end(at); at.increment(error)) {
    const std::string extension = bagExtension(at->path());
    if (extension == ".db3" || extension == ".mcap") return true;
    (extension.empty() ? others : found) = true;
  }
  return found && !others;
}

BagFiles bagFilesIn(const fs::path& folder) {
  BagFiles bag;
  const std::string name = printable(folder.string());
  const fs::path metadata = folder / "metadata.yaml";
  if (std::error_code none; fs::exists(metadata, none)) {
    const std::vector<std::string> listed = listedFiles(metadata);
    bag = filesOf(folder, listed);
    if (!bag.files.empty()) return bag;
    if (listed.empty())
      bag.warnings.push_back(
          fmt::format("{}: its metadata.yaml lists no files, so all bags in it are read", name));
  }
  bag.files = bagFilesBeside(folder);
  if (bag.files.empty() && !bag.warnings.empty()) fail(ErrorCode::fileNotFound, "{}", bag.warnings.front());
  if (bag.files.empty())
    fail(ErrorCode::unsupportedFile, "{}: no bag in this folder; give one with .mcap, .db3 or .bag files",
         name);
  std::set<std::string> extensions;
  for (const fs::path& file : bag.files) extensions.insert(bagExtension(file));
  if (extensions.size() > 1)
    fail(ErrorCode::unsupportedFile, "{}: bags of several formats ({}); give one of them", name,
         fmt::join(extensions, ", "));
  return bag;
}

}  // namespace estancia::ros
