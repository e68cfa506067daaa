// One folder a class, as 15-Scene and most sets for scene classification are given out: CLASS/*.jpg, or
// train/CLASS/*.jpg and test/CLASS/*.jpg. The folder's name is the room of the frames in it.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// The folders in `path`, hidden ones left out, in natural order.
std::vector<fs::path> foldersIn(const fs::path& path) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(path)) {
    std::error_code unreadable;
    if (entry.is_directory(unreadable) && !entry.path().filename().native().starts_with('.'))
      folders.push_back(entry.path());
  }
  std::ranges::sort(folders, [](const fs::path& a, const fs::path& b) {
    return naturalLess(a.filename().native(), b.filename().native());
  });
  return folders;
}

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

/// Only what can be nothing else: two halves of the same classes, at least two. Other folders full of folders
/// may be the pieces of one drive, whose names are no rooms: those are read as classes when the user says so.
bool isClasses(const fs::path& path) {
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

Opened openClasses(const fs::path& path, const SequenceOptions&) {
  auto sequence = std::make_unique<ImageFiles>(nameOf(path));
  std::vector<std::string> leftOut;
  const auto add = [&](const fs::path& folder, const std::string& split) {
    const auto files = filesIn(folder, imageSuffixes());
    const std::string room = printable(folder.filename().string());
    const std::string prefix = (split.empty() ? "" : split + "/") + room + "/";
    if (files.empty()) leftOut.push_back(prefix);
    for (const fs::path& file : files) {
      Frame frame;
      frame.name = prefix + printable(file.filename().string());
      frame.room = room;
      sequence->add(std::move(frame), file);
      if (!split.empty()) sequence->splits().push_back(split);
    }
  };
  const auto splits = splitsIn(path);
  for (const fs::path& folder : foldersIn(path))
    if (splits.empty())
      add(folder, "");
    else if (std::ranges::find(splits, folder) == splits.end())
      leftOut.push_back(printable(folder.filename().string()) + "/");
    else
      for (const fs::path& room : foldersIn(folder)) add(room, printable(folder.filename().string()));
  if (sequence->size() == 0)
    throw Error(
        fmt::format("{}: none of its folders holds images; each class is a folder of its own, perhaps "
                    "in train/ and test/",
                    printable(path.string())));
  if (const auto loose = filesIn(path, imageSuffixes()); !loose.empty())
    sequence->warn(fmt::format("{} images in no folder of a class are left out (first: {})", loose.size(),
                               printable(loose.front().filename().string())));
  if (!leftOut.empty())
    sequence->warn(fmt::format("{} folders are no class with images and are left out (first: {})",
                               leftOut.size(), leftOut.front()));
  return sequence;
}

}  // namespace estancia::io
