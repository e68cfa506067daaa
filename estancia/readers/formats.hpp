// Sequence formats: the table of readers, one in the file of its name, and all that they share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estancia/sequences/listed_sequence.hpp"

namespace estancia::io {

using SequenceFormat = Format<Opened, SequenceOptions>;

template <class OneSequence>
Opened openAs(const std::filesystem::path& path, const SequenceOptions& options) {
  return std::make_unique<OneSequence>(path, options);
}

// One per format, in the file of its name.
extern const SequenceFormat bagFormat, videoFormat, tumFormat, sevenScenesFormat, panoramaFormat, idol2Format,
    nyuFormat, rgbdFoldersFormat, vidriloFormat, classesFormat, imageFolderFormat;

/// Formats of sequences with images, in order of detection: special before general ones, plain folders last.
inline std::vector<SequenceFormat> imageFormats() {
  return {bagFormat, videoFormat,       tumFormat,     sevenScenesFormat, panoramaFormat,   idol2Format,
          nyuFormat, rgbdFoldersFormat, vidriloFormat, classesFormat,     imageFolderFormat};
}

// Shared by readers.
bool isImageFolder(const std::filesystem::path& path);
/// Whether folders of images lie in `path`, or in train/, test/ … in it: one a room, if they are meant so.
bool mayBeClasses(const std::filesystem::path& path);
/// The folders of images in train/, test/ …, as "train/kitchen".
std::vector<std::string> nestedClasses(const std::filesystem::path& path);
/// Readable image formats, for messages: imageSuffixes().
constexpr const char* readFormats = "jpg, png, bmp, tif, webp, pgm, ppm";
/// "2 images are of other formats, a.heic first; …", "" where there are none.
std::string otherImages(const std::filesystem::path& folder);

}  // namespace estancia::io
