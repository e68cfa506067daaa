// Opening a sequence: videos, image folders and robotics data sets, detected by content.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "estancia/core/options.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia {

OptionGroup declare(SequenceOptions& options);
/// Throws Error on an option out of its range; depthScale is 0 or at least 1e-6.
void validate(const SequenceOptions& options);

/// Opens a folder, a video file, a descriptor file, a folder of panoramas …
/// Throws Error when the path does not exist, the format is not recognized, a side file is malformed, or the
/// split or a room is unknown (naming the known ones).
std::unique_ptr<Sequence> openSequence(const std::filesystem::path& path,
                                       const SequenceOptions& options = {});

/// Single image files in the given order; frames are named by their paths. Throws Error for missing files and
/// other file types.
std::unique_ptr<Sequence> openImages(const std::vector<std::filesystem::path>& files);

/// True for existing files with the extension of an image.
bool isImageFile(const std::filesystem::path& file);

/// The values of SequenceOptions::type besides "auto".
Choices sequenceTypes();

}  // namespace estancia
