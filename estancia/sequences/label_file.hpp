// Label file NAME.labels: a descriptor sequence in binary, exact, as `estancia label` writes it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia::io {

/// Magic, format version and the vocabulary's digest, then model, labels and frames, then float32 N×L.
/// Throws Error when the file cannot be written; then nothing remains of it.
void writeLabelFile(const DescriptorSequence& sequence, const std::filesystem::path& file);

/// Throws Error when it is no label file, of a newer version, truncated or damaged.
DescriptorSequence readLabelFile(const std::filesystem::path& file);

}  // namespace estancia::io
