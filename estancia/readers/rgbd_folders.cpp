// RGB-D folders: images in rgb/ (or color/, image/ …) and depth in depth/. The depth of an image has the same
// name without extension, or, where all names are time stamps, the nearest time stamp.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <unordered_map>

#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr const char* imageFolders[] = {"rgb", "color", "colour", "image", "images"};

/// The folder of the images; "" when there is none.
fs::path imageFolder(const fs::path& path) {
  for (const char* name : imageFolders)
    if (isImageFolder(path / name)) return path / name;
  return {};
}

bool isTimed(const std::vector<fs::path>& files) {
  return std::ranges::all_of(files, [](const fs::path& f) { return timestampOf(f).has_value(); });
}

}  // namespace

static bool isRgbdFolders(const fs::path& path) {
  return fs::is_directory(path) && !isImageFolder(path) && fs::is_directory(path / "depth") &&
         !filesIn(path / "depth", depthSuffixes()).empty() && !imageFolder(path).empty();
}

static Opened openRgbdFolders(const fs::path& path, const SequenceOptions& options) {
  const fs::path folder = imageFolder(path);
  if (folder.empty() || !fs::is_directory(path / "depth"))
    fail(ErrorCode::insufficientData, "{}: no images in a folder rgb, color or image beside a folder depth",
         printable(path));
  const auto images = filesIn(folder, imageSuffixes()), depths = filesIn(path / "depth", depthSuffixes());
  const bool timed = isTimed(images), depthTimed = isTimed(depths);
  std::unordered_map<std::string, fs::path> byStem;
  std::vector<TimedFile> byTime;
  for (const auto& file : depths) {
    byStem.emplace(file.stem().string(), file);
    if (depthTimed) byTime.push_back({*timestampOf(file), file});
  }
  std::ranges::stable_sort(byTime, {}, &TimedFile::timestamp);

  auto sequence = std::make_unique<ImageFiles>(nameOf(path), options.depthScale);
  for (const auto& file : images) {
    Frame frame{printable(file.filename()), timed ? timestampOf(file) : std::nullopt, {}, {}};
    DepthFile depth;
    if (timed && depthTimed)
      depth = nearestDepth(byTime, *frame.timestamp);
    else if (const auto found = byStem.find(file.stem().string()); found != byStem.end())
      depth.file = found->second;
    sequence->add(std::move(frame), file, std::move(depth));
  }
  return sequence;
}

const SequenceFormat rgbdFoldersFormat{
    "rgbd", "two folders: rgb/ (or color/, image/) and depth/ with the same file names", isRgbdFolders,
    openRgbdFolders};

}  // namespace estancia::io
