// Descriptor files: the label probabilities of a sequence as .labels, CSV, JSON lines or NPY.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Labeled frames. Invariant: one row of `descriptors` per frame, one column per label of the vocabulary.
struct DescriptorSequence {
  Vocabulary vocabulary;
  /// Identity of the labeler: a name and a digest.
  std::string model;
  /// In the order of the file.
  std::vector<Frame> frames;
  DescriptorMatrix descriptors;
};

/// The files beside a descriptor file.
struct DescriptorFileOptions {
  /// A label file. With CSV and JSON lines it fixes the labels and their order (JSON lines and long CSV:
  /// other labels are dropped; wide CSV: the columns must be these); without it the labels are those of the
  /// file, in order of appearance. With NPY it names the columns; "" takes NAME.labels.txt beside NAME.npy.
  std::filesystem::path labels;
  /// NPY only: the names of the rows, as a CSV with a column `image` (and optionally timestamp, x, y, z, qx,
  /// qy, qz, qw, room) or one name per line. "" takes NAME.frames.csv beside NAME.npy; without that file the
  /// frames are named by their order as in a video: "frame 000000" …
  std::filesystem::path frames;
};
OptionGroup declare(DescriptorFileOptions& options);

/// True for the extensions that readDescriptors() reads: .labels, .csv, .jsonl, .ndjson, .npy.
bool isDescriptorFile(const std::filesystem::path& file);

/// Reads a descriptor file by its extension:
///  * .labels: written by writeDescriptors(), binary and exact; of this version only;
///  * .csv, wide: a header `image,LABEL,…`, then one line of probabilities per image;
///  * .csv, long: a header `image,label,probability`, then one line per label; missing labels are 0;
///  * .jsonl, .ndjson: {"image": …, "labels": {LABEL: probability, …}} per line, or a list
///    [{"label": …, "confidence": …}, …]; lines with an "error" have no labels and are left out;
///  * .npy: float32 or float64, C order, N×L.
/// Throws Error `FILE:LINE: …` on values that are not probabilities (values within rounding of [0, 1] are
/// clamped), on repeated images and on truncated files.
DescriptorSequence readDescriptors(const std::filesystem::path& file,
                                   const DescriptorFileOptions& options = {});

/// Writes .labels (everything, exact), .csv (wide; every probability reads back as the same float32) or .npy
/// (float32 N×L, with NAME.labels.txt and NAME.frames.csv), by file extension. Throws Error on others.
void writeDescriptors(const DescriptorSequence& sequence, const std::filesystem::path& file);

/// All files that writeDescriptors() writes for this name: three for .npy, one for others.
std::vector<std::filesystem::path> descriptorFilesOf(const std::filesystem::path& file);

/// Throws Error unless writeDescriptors() writes files with this extension.
void requireDescriptorFile(const std::filesystem::path& file);

/// Converts the frames to another vocabulary: labels that it lacks are dropped, its other labels are 0.
DescriptorSequence toVocabulary(const DescriptorSequence& sequence, const Vocabulary& vocabulary);

}  // namespace estancia
