// A folder of images, in the natural order of their names.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

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
  const bool single = isImageFile(path);
  const auto files = single ? std::vector{path} : filesIn(path, imageSuffixes());
  const std::string others = single ? "" : otherImages(path);
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

const SequenceFormat imageFolderFormat{
    "folder", "a folder of images, in natural order of their names, or a single image",
    [](const fs::path& path) { return isImageFolder(path) || isImageFile(path); }, openImageFolder};

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
