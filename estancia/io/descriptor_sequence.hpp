// Descriptors made elsewhere, or once before: label files, CSV, JSON lines, NPY.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

/// Frames with their words. Invariant: one row of `descriptors` a frame, one column a label.
struct DescriptorSequence {
  Vocabulary vocabulary;
  std::string model;          ///< identity of the labeler that made it; a name and a digest
  std::vector<Frame> frames;  ///< in the file's order
  DescriptorMatrix descriptors;
};

/// What a recording needs beside its own file.
struct DescriptorFileOptions {
  /// A label file. Beside CSV and JSON lines it fixes the words and their order (other words are dropped, a
  /// CSV's columns must be these); without it the words are those of the file, in the order they appear. For
  /// NPY the names of the columns; "" takes NAME.labels.txt beside NAME.npy.
  std::filesystem::path labels;
  /// For NPY: the names of its rows, a CSV with a column `image` (and, where known, timestamp, x, y, z, qx,
  /// qy, qz, qw, room), or one name a line. "" takes NAME.frames.csv beside NAME.npy; when that is missing,
  /// the frames are called "frame 000000" … as a video's are, so that order tells which is which.
  std::filesystem::path frames;
};

/// Whether readDescriptors() reads files of this name: .labels, .csv, .jsonl, .ndjson or .npy.
bool isDescriptorFile(const std::filesystem::path& file);

/// Reads, by the file's name,
///  * .labels: what writeDescriptors() made, see label_file.hpp;
///  * .csv, wide: a header `image,LABEL,…`, then a line of probabilities an image;
///  * .csv, long: a header `image,label,probability`, then a line a word; words that are not named are 0;
///  * .jsonl, .ndjson: {"image": …, "labels": {LABEL: probability, …}} a line, or a list
///    [{"label": …, "confidence": …}, …]; lines with an "error" have no words and are left out;
///  * .npy: float32 or float64, C order, N×L.
/// Throws Error `FILE:LINE: …` on anything that is no probability (values within rounding of [0, 1] are
/// clamped), on repeated images and on files that are cut short.
DescriptorSequence readDescriptors(const std::filesystem::path& file,
                                   const DescriptorFileOptions& options = {});

/// Writes by the file's name: .labels (everything, exact), .csv or .npy. Throws Error on other names.
void writeDescriptors(const DescriptorSequence& recording, const std::filesystem::path& file);

/// The files that writeDescriptors() makes for this name: with .npy two more, for words and frames.
std::vector<std::filesystem::path> filesOfRecording(const std::filesystem::path& file);

/// Throws Error unless writeDescriptors() writes files of this name.
void requireRecordingName(const std::filesystem::path& file);

/// The same frames in the words of another vocabulary: words that it lacks are dropped, words that are new
/// in it are 0.
DescriptorSequence inWordsOf(const Vocabulary& vocabulary, const DescriptorSequence& recording);

/// Writes the wide CSV; every probability reads back as the same float32.
void writeCsv(const DescriptorSequence& recording, const std::filesystem::path& file);

/// Writes float32 N×L, NAME.labels.txt and NAME.frames.csv beside it. Throws Error unless `file` ends in
/// .npy.
void writeNpy(const DescriptorSequence& recording, const std::filesystem::path& file);

}  // namespace estancia
