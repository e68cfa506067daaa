// Folder of classes, as 15-Scene and most scene classification data sets: CLASS/*.jpg, or train/CLASS/*.jpg
// and test/CLASS/*.jpg. The folder's name is the room of its frames.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

bool namesSplit(const fs::path& folder) {
  static const std::set<std::string> names = {"train",      "training", "val",    "valid",
                                              "validation", "test",     "testing"};
  return names.contains(folder.filename().string());
}

/// The folders in `path` that hold images.
std::vector<fs::path> classesIn(const fs::path& path) {
  auto folders = foldersIn(path);
  std::erase_if(folders, [](const fs::path& folder) { return !isImageFolder(folder); });
  return folders;
}

/// The folders train, test … in `path` that hold classes.
std::vector<fs::path> splitsIn(const fs::path& path) {
  auto folders = foldersIn(path);
  std::erase_if(folders, [](const fs::path& f) { return !namesSplit(f) || classesIn(f).empty(); });
  return folders;
}

}  // namespace

/// Detects only train/test folders with the same classes, at least two. Other nested folders may be the parts
/// of one drive, whose names are no rooms: they are read as classes on request.
static bool isClasses(const fs::path& path) {
  if (!fs::is_directory(path) || isImageFolder(path)) return false;
  const auto splits = splitsIn(path);
  const auto namesOf = [](const fs::path& split) {
    std::vector<std::string> names;
    for (const fs::path& folder : classesIn(split)) names.push_back(folder.filename().string());
    return names;
  };
  if (splits.size() < 2) return false;
  const auto first = namesOf(splits[0]);
  return first.size() > 1 &&
         std::ranges::all_of(splits, [&](const fs::path& split) { return namesOf(split) == first; });
}

std::vector<std::string> nestedClasses(const fs::path& path) {
  std::vector<std::string> classes;
  if (!fs::is_directory(path)) return classes;
  for (const fs::path& split : splitsIn(path))
    for (const fs::path& folder : classesIn(split))
      classes.push_back(printable(split.filename()) + "/" + printable(folder.filename()));
  return classes;
}

bool mayBeClasses(const fs::path& path) {
  return fs::is_directory(path) && (!classesIn(path).empty() || !splitsIn(path).empty());
}

static Opened openClasses(const fs::path& path, const SequenceOptions&) {
  auto sequence = std::make_unique<ImageFiles>(nameOf(path));
  std::vector<std::string> leftOut;
  const auto add = [&](const fs::path& folder, const std::string& split) {
    const auto files = filesIn(folder, imageSuffixes());
    const std::string room = printable(folder.filename());
    const std::string prefix = (split.empty() ? "" : split + "/") + room + "/";
    if (files.empty()) leftOut.push_back(prefix);
    for (const fs::path& file : files) {
      sequence->add({prefix + printable(file.filename()), {}, {}, room}, file);
      if (!split.empty()) sequence->splits().push_back(split);
    }
  };
  const auto splits = splitsIn(path);
  for (const fs::path& folder : foldersIn(path))
    if (splits.empty())
      add(folder, "");
    else if (std::ranges::find(splits, folder) == splits.end())
      leftOut.push_back(printable(folder.filename()) + "/");
    else
      for (const fs::path& room : foldersIn(folder)) add(room, printable(folder.filename()));
  if (sequence->size() == 0)
    fail(
        ErrorCode::insufficientData,
        "{}: no images in its folders; put each class in a folder of its own, optionally in train/ and test/",
        printable(path));
  if (const auto loose = filesIn(path, imageSuffixes()); !loose.empty())
    sequence->warn(fmt::format("{} images outside of class folders are left out (first: {})", loose.size(),
                               printable(loose.front().filename())));
  if (!leftOut.empty())
    sequence->warn(fmt::format("{} folders without images of a class are left out (first: {})",
                               leftOut.size(), leftOut.front()));
  return sequence;
}

const SequenceFormat classesFormat{
    "classes", "one folder of images per room, optionally in train/ and test/ (auto detects only these)",
    isClasses, openClasses};

}  // namespace estancia::io
