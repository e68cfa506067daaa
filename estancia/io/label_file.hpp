// The label file `NAME.labels`: a sequence's words, whole and exact, as `estancia label` writes them.
#pragma once

#include <filesystem>

#include "estancia/io/descriptor_sequence.hpp"

namespace estancia::io {

/// Magic, format version and the vocabulary's digest, then model, words and frames, then float32 N×L.
/// Throws Error when the file cannot be written; then nothing is left of it.
void writeLabelFile(const DescriptorSequence& recording, const std::filesystem::path& file);

/// Reads it back. Throws Error when it is no label file, of a newer version, cut short or damaged.
DescriptorSequence readLabelFile(const std::filesystem::path& file);

}  // namespace estancia::io
