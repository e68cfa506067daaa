// Sequence formats: one reader per data set, in the file of its name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estancia/sequences/listed_sequence.hpp"

namespace estancia::io {

// One pair per format, in the file of its name: does `path` look like it, and open it.
bool isRosBag(const std::filesystem::path& path);
Opened openRosBag(const std::filesystem::path& path, const SequenceOptions& options);
bool isVideo(const std::filesystem::path& path);
Opened openVideo(const std::filesystem::path& path, const SequenceOptions& options);
bool isTumRgbd(const std::filesystem::path& path);
Opened openTumRgbd(const std::filesystem::path& path, const SequenceOptions& options);
bool isSevenScenes(const std::filesystem::path& path);
Opened openSevenScenes(const std::filesystem::path& path, const SequenceOptions& options);
bool isPanoramas(const std::filesystem::path& path);
Opened openPanoramas(const std::filesystem::path& path, const SequenceOptions& options);
bool isIdol2(const std::filesystem::path& path);
Opened openIdol2(const std::filesystem::path& path, const SequenceOptions& options);
bool isNyu(const std::filesystem::path& path);
Opened openNyu(const std::filesystem::path& path, const SequenceOptions& options);
bool isRgbdFolders(const std::filesystem::path& path);
Opened openRgbdFolders(const std::filesystem::path& path, const SequenceOptions& options);
bool isVidrilo(const std::filesystem::path& path);
Opened openVidrilo(const std::filesystem::path& path, const SequenceOptions& options);
bool isClasses(const std::filesystem::path& path);
Opened openClasses(const std::filesystem::path& path, const SequenceOptions& options);
bool isImageFolder(const std::filesystem::path& path);
/// Whether folders of images lie in `path`, or in train/, test/ … in it: one a room, if they are meant so.
bool mayBeClasses(const std::filesystem::path& path);
/// The folders of images in train/, test/ …, as "train/kitchen".
std::vector<std::string> nestedClasses(const std::filesystem::path& path);
/// Readable image formats, for messages: imageSuffixes().
constexpr const char* readFormats = "jpg, png, bmp, tif, webp, pgm, ppm";
/// "2 images are of other formats, a.heic first; …", "" where there are none.
std::string otherImages(const std::filesystem::path& folder);
Opened openImageFolder(const std::filesystem::path& path, const SequenceOptions& options);

}  // namespace estancia::io
