// Folders of images: a plain one, in the natural order of names, and RGB-D folders.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "estancia/readers/formats.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

/// Images as phones, cameras and the web have them, which this program does not decode.
const std::vector<std::string>& otherImageSuffixes() {
  static const std::vector<std::string> suffixes = {".heic", ".heif", ".avif", ".gif", ".jxl",
                                                    ".dng",  ".cr2",  ".nef",  ".arw"};
  return suffixes;
}

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

std::string otherImages(const fs::path& folder) {
  const auto others = filesIn(folder, otherImageSuffixes());
  if (others.empty()) return "";
  return fmt::format("{} {} of other formats, {} first; convert them to one of these: {}", others.size(),
                     others.size() == 1 ? "image is" : "images are", printable(others.front().filename()),
                     readFormats);
}

bool isImageFolder(const fs::path& path) {
  return fs::is_directory(path) && !filesIn(path, imageSuffixes()).empty();
}

static Opened openImageFolder(const fs::path& path, const SequenceOptions&) {
  const auto files = filesIn(path, imageSuffixes());
  const std::string others = otherImages(path);
  if (files.empty())
    fail(ErrorCode::insufficientData, "{}: no images in this folder ({}){}", printable(path), readFormats,
         others.empty() ? "" : "; " + others);
  const bool timed = std::ranges::all_of(files, [](const fs::path& f) { return timestampOf(f).has_value(); });
  auto sequence = std::make_unique<ImageFiles>(nameOf(path));
  for (const auto& file : files)
    sequence->add({printable(file.filename()), timed ? timestampOf(file) : std::nullopt, {}, {}}, file);
  if (!others.empty()) sequence->warn("left out: " + others);
  return sequence;
}

const SequenceFormat imageFolderFormat{"folder", "a folder of images, in natural order of their names",
                                       isImageFolder, openImageFolder};

static bool isRgbdFolders(const fs::path& path) {
  return fs::is_directory(path) && !isImageFolder(path) && fs::is_directory(path / "depth") &&
         !filesIn(path / "depth", depthSuffixes()).empty() && !imageFolder(path).empty();
}

/// Images are in rgb/ (or color/, image/ …), depth is in depth/: under the name of the image without
/// extension, or, where all names are time stamps, under the nearest time stamp.
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

namespace estancia {

bool isImageFile(const std::filesystem::path& file) {
  return std::filesystem::is_regular_file(file) && io::hasSuffix(file, io::imageSuffixes());
}

std::unique_ptr<Sequence> openImages(const std::vector<std::filesystem::path>& files) {
  if (files.empty()) throw Error(ErrorCode::invalidInput, "no image files given; name at least one");
  auto sequence = std::make_unique<io::ImageFiles>(files.size() == 1 ? io::nameOf(files[0]) : "images");
  for (const auto& file : files) {
    const std::string name = io::printable(file);
    if (!std::filesystem::exists(file)) fail(ErrorCode::fileNotFound, "{}: no such file", name);
    if (!isImageFile(file)) fail(ErrorCode::unsupportedFile, "{}: not an image ({})", name, io::readFormats);
    sequence->add({name, {}, {}, {}}, file);
  }
  return sequence;
}

}  // namespace estancia
