// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/descriptor_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/printable_labels.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/frame_list.hpp"
#include "estancia/files/label_scores.hpp"
#include "estancia/files/npy.hpp"
#include "estancia/files/path_option.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

std::string at(const fs::path& file, std::size_t line) {
  return fmt::format("{}:{}", io::printable(file), line);
}

std::optional<Vocabulary> givenLabels(const DescriptorFileOptions& options) {
  if (options.labels.empty()) return std::nullopt;
  return readVocabulary(options.labels);
}

DescriptorSequence sequenceOf(const fs::path& file, Vocabulary vocabulary, std::vector<Frame> frames,
                              DescriptorMatrix descriptors) {
  if (frames.empty()) fail(ErrorCode::insufficientData, "{}: no images", io::printable(file));
  // Files do not name their labeler. One vocabulary counts as one, so that maps localize other sequences.
  std::string model = "recorded " + vocabulary.digest();
  return {std::move(vocabulary), std::move(model), std::move(frames), std::move(descriptors)};
}

/// Images with sparse labels, which finish() turns into rows of probabilities.
class SparseRows {
 public:
  explicit SparseRows(const DescriptorFileOptions& options) {
    if (auto vocabulary = givenLabels(options)) book_ = io::WordBook(std::move(*vocabulary));
  }

  void add(std::string image, std::vector<LabelProbability> words, const std::string& source) {
    frames_.push_back({std::move(image), {}, {}, {}});
    places_.push_back(book_.place(std::move(words), 0, source));
  }

  DescriptorSequence finish(const fs::path& file) {
    // A small file can name many images and many labels; memory must hold their product.
    constexpr std::size_t maxValues = 500'000'000;
    if (!frames_.empty() && book_.size() > maxValues / frames_.size())
      fail(ErrorCode::tooLarge,
           "{}: {} images × {} labels; at most {} values are read; give a label file with fewer labels",
           io::printable(file), frames_.size(), book_.size(), maxValues);
    if (frames_.empty() || book_.size() == 0)
      fail(ErrorCode::insufficientData, "{}: no {}", io::printable(file),
           frames_.empty() ? "images" : "labels");
    DescriptorMatrix descriptors(book_.size());
    descriptors.reserve(frames_.size());
    for (const auto& indices : places_) descriptors.append(book_.toDescriptor(indices));
    return sequenceOf(file, book_.vocabulary(), std::move(frames_), std::move(descriptors));
  }

 private:
  io::WordBook book_;
  std::vector<Frame> frames_;
  std::vector<io::WordBook::Places> places_;
};

double numberOf(const std::string& cell, const std::string& label, const std::string& where) {
  const auto value = io::toNumber(cell);
  if (!value)
    fail(ErrorCode::malformedFile, "{}: \"{}\" is \"{}\", not a number", where, label, io::printable(cell));
  return *value;
}

DescriptorSequence readWideCsv(const fs::path& file, const DescriptorFileOptions& options) {
  std::vector<std::string> labels;
  std::vector<Frame> frames;
  std::optional<DescriptorMatrix> descriptors;
  io::UniqueNames names;
  LexicalDescriptor values;
  io::forEachCsvRow(file, [&](io::CsvRow& row) {
    const std::string where = at(file, row.line);
    if (labels.empty()) {  // the header
      for (std::size_t i = 1; i < row.cells.size(); ++i)
        labels.push_back(io::toLabel(row.cells[i], fmt::format("{}: column {}", where, i + 1)));
      if (labels.empty())
        fail(ErrorCode::malformedFile, "{}: no labels in the header; write `image,LABEL,…`", where);
      descriptors.emplace(labels.size());
      values.resize(labels.size());
      return;
    }
    if (row.cells.size() != labels.size() + 1)
      fail(ErrorCode::malformedFile, "{}: {} cells instead of {}; is the file truncated?", where,
           row.cells.size(), labels.size() + 1);
    std::string image = io::printable(row.cells[0]);
    names.add(image, file, row.line);
    for (std::size_t i = 0; i < labels.size(); ++i)
      values[i] = io::toProbability(numberOf(row.cells[i + 1], labels[i], where), labels[i], where);
    frames.push_back({std::move(image), {}, {}, {}});
    descriptors->append(values);
  });
  Vocabulary vocabulary(std::move(labels));
  if (const auto given = givenLabels(options)) requireSameVocabulary(*given, vocabulary, io::printable(file));
  return sequenceOf(file, std::move(vocabulary), std::move(frames), std::move(*descriptors));
}

DescriptorSequence readLongCsv(const fs::path& file, const DescriptorFileOptions& options) {
  std::vector<std::string> images;  // in the order in which they appear
  std::vector<std::vector<LabelProbability>> words;
  std::unordered_map<std::string, std::size_t> indices;
  bool header = true;
  io::forEachCsvRow(file, [&](io::CsvRow& row) {
    if (std::exchange(header, false)) return;
    const std::string where = at(file, row.line);
    if (row.cells.size() != 3)
      fail(ErrorCode::malformedFile, "{}: {} cells instead of 3: `image,label,probability`", where,
           row.cells.size());
    std::string image = io::printable(row.cells[0]), label = io::toLabel(row.cells[1], where);
    if (image.empty()) fail(ErrorCode::malformedFile, "{}: empty image name", where);
    const float value = io::toProbability(numberOf(row.cells[2], label, where), label, where);
    const auto [entry, isNew] = indices.emplace(image, images.size());
    if (isNew) {
      images.push_back(std::move(image));
      words.emplace_back();
    }
    words[entry->second].push_back({std::move(label), value});
  });
  SparseRows rows(options);
  for (std::size_t i = 0; i < images.size(); ++i)
    rows.add(std::move(images[i]), std::move(words[i]), io::printable(file));
  return rows.finish(file);
}

/// Wide or long, by the header.
DescriptorSequence readCsv(const fs::path& file, const DescriptorFileOptions& options) {
  if (!fs::is_regular_file(file) || !std::ifstream(file))
    fail(fs::exists(file) ? ErrorCode::fileUnreadable : ErrorCode::fileNotFound,
         "{}: no readable file; check its name and its permissions", io::printable(file));
  std::string start = io::firstBytes(file, 256);
  if (start.starts_with("\xEF\xBB\xBF")) start.erase(0, 3);
  std::erase_if(start, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; });
  const std::string header = start.substr(0, start.find('\n'));
  if (header == "image,label,probability" || header == "image,label,confidence")
    return readLongCsv(file, options);
  if (header.starts_with("image,")) return readWideCsv(file, options);
  fail(ErrorCode::malformedFile, "{}: no header; write `image,LABEL,…` or `image,label,probability`",
       at(file, 1));
}

DescriptorSequence readJsonLines(const fs::path& file, const DescriptorFileOptions& options) {
  SparseRows rows(options);
  io::UniqueNames names;
  const auto lines = io::readLines(file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].find_first_not_of(" \t") == std::string::npos) continue;
    const std::string where = at(file, i + 1);
    io::Answer answer = io::readAnswer(lines[i], {}, where);
    std::string image = io::printable(answer.image);
    names.add(image, file, i + 1);
    if (answer.error.empty()) rows.add(std::move(image), std::move(answer.words), where);
  }
  return rows.finish(file);
}

fs::path beside(const fs::path& npy, const char* ending) {
  return fs::path(npy).replace_extension(ending);
}

DescriptorSequence readNpy(const fs::path& file, const DescriptorFileOptions& options) {
  io::NpyFile matrix(file);
  const std::string name = io::printable(file);
  const fs::path labels = options.labels.empty() ? beside(file, ".labels.txt") : options.labels;
  if (!fs::is_regular_file(labels))
    fail(ErrorCode::insufficientData,
         "{}: the labels of the {} columns are unknown; write them, one per line, to {}", name,
         matrix.columns(), io::printable(labels));
  Vocabulary vocabulary = readVocabulary(labels);
  if (vocabulary.size() != matrix.columns())
    fail(ErrorCode::mismatch, "{}: {} columns, but {} has {} labels; give its own label file", name,
         matrix.columns(), io::printable(labels), vocabulary.size());
  fs::path list = options.frames;
  if (list.empty() && fs::exists(beside(file, ".frames.csv"))) list = beside(file, ".frames.csv");
  std::vector<Frame> frames;
  if (!list.empty()) frames = io::readFrameList(list);
  for (std::size_t i = 0; list.empty() && i < matrix.rows(); ++i)
    frames.push_back({fmt::format("frame {:06}", i), {}, {}, {}});
  if (frames.size() != matrix.rows())
    fail(ErrorCode::mismatch, "{}: {} rows, but {} names {} images", name, matrix.rows(), io::printable(list),
         frames.size());
  DescriptorMatrix descriptors(vocabulary.size());
  descriptors.reserve(matrix.rows());
  LexicalDescriptor values(vocabulary.size());
  for (std::size_t i = 0; i < matrix.rows(); ++i) {
    const auto& row = matrix.next();
    const std::string where = fmt::format("{}: row {}", name, i);
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = io::toProbability(row[k], vocabulary[k], where);
    descriptors.append(values);
  }
  return sequenceOf(file, std::move(vocabulary), std::move(frames), std::move(descriptors));
}

void writeCsv(const DescriptorSequence& sequence, const fs::path& file) {
  std::string text = "image";
  for (const auto& label : sequence.vocabulary.labels()) text += ',' + io::csvCell(label);
  text += '\n';
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    text += io::csvCell(sequence.frames[i].name);
    for (const float p : sequence.descriptors.row(i)) fmt::format_to(std::back_inserter(text), ",{}", p);
    text += '\n';
  }
  writeWhole(file, text);
}

void writeNpy(const DescriptorSequence& sequence, const fs::path& file) {
  std::string labels;
  for (const auto& label : sequence.vocabulary.labels()) labels += label + '\n';
  writeWhole(beside(file, ".labels.txt"), labels);
  writeWhole(beside(file, ".frames.csv"), io::frameListText(sequence.frames));
  writeWhole(file, io::npyBytes(sequence.descriptors));  // last: its existence means success
}

// A label file: magic, version, the vocabulary's digest, then model, labels and frames, then float32 N×L.
constexpr std::string_view labelFileMagic = "ESTLABEL";
constexpr std::uint32_t labelFileVersion = 1;
constexpr std::size_t maxLabelFileBytes = std::size_t{64} << 30;

void writeFrame(ByteWriter& out, const Frame& frame) {
  out.text(frame.name);
  out.text(frame.room);
  out.number(static_cast<std::uint8_t>((frame.timestamp ? 1 : 0) | (frame.pose ? 2 : 0)));
  if (frame.timestamp) out.number(*frame.timestamp);
  if (const auto& p = frame.pose)
    for (const double value : {p->x, p->y, p->z, p->qx, p->qy, p->qz, p->qw}) out.number(value);
}

Frame readFrame(ByteReader& in) {
  Frame frame;
  frame.name = io::printable(in.text());
  frame.room = io::printable(in.text());
  const auto known = in.number<std::uint8_t>();
  if ((known & 1) != 0) frame.timestamp = in.number<double>();
  if (frame.timestamp && !std::isfinite(*frame.timestamp)) in.fail("it is damaged (a time is not finite)");
  if ((known & 2) != 0) {
    Pose& p = frame.pose.emplace();
    for (double* value : {&p.x, &p.y, &p.z, &p.qx, &p.qy, &p.qz, &p.qw}) *value = in.number<double>();
    if (!p.isPlausible()) in.fail("it is damaged (a pose is not finite, or beyond 10 000 km)");
  }
  return frame;
}

void writeLabelFile(const DescriptorSequence& sequence, const fs::path& file) {
  ByteWriter out;
  out.raw(labelFileMagic);
  out.number(labelFileVersion);
  out.raw(sequence.vocabulary.digest());
  out.text(sequence.model);
  out.number(static_cast<std::uint64_t>(sequence.vocabulary.size()));
  for (const std::string& label : sequence.vocabulary.labels()) out.text(label);
  const auto& parts = sequence.vocabulary.layout().parts;
  out.number(static_cast<std::uint64_t>(parts.size()));
  for (const LabelPart& part : parts) {
    out.number(static_cast<std::uint64_t>(part.size));
    out.number(part.weight);
  }
  out.number(static_cast<std::uint64_t>(sequence.frames.size()));
  for (const Frame& frame : sequence.frames) writeFrame(out, frame);
  const auto values = std::span(sequence.descriptors.values());
  out.raw({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  writeWhole(file, out.bytes());
}

DescriptorSequence readLabelFile(const fs::path& file) {
  const std::string bytes = io::readBytes(file, maxLabelFileBytes);
  ByteReader in(bytes, io::printable(file), "label the sequence again");
  if (!bytes.starts_with(labelFileMagic))
    fail(ErrorCode::unsupportedFile, "{}: not a label file; give one that `estancia label` has written",
         io::printable(file));
  in.raw(labelFileMagic.size());
  if (const auto found = in.number<std::uint32_t>(); found != labelFileVersion)
    fail(ErrorCode::unsupportedFile,
         "{}: label file of version {}; this program reads version {}; update Estancia", io::printable(file),
         found, labelFileVersion);
  const std::string digest(in.raw(64));
  std::string model = io::printable(in.text());
  const auto labelCount = in.number<std::uint64_t>();
  if (labelCount == 0 || labelCount > in.remaining()) in.fail("it is truncated", ErrorCode::truncatedFile);
  std::vector<std::string> labels;
  for (std::uint64_t i = 0; i < labelCount; ++i) labels.push_back(in.text());
  const auto partCount = in.number<std::uint64_t>();
  if (partCount > labelCount) in.fail("it is damaged (more parts than labels)");
  std::vector<LabelPart> parts;
  for (std::uint64_t i = 0; i < partCount; ++i) {
    const auto size = in.number<std::uint64_t>();
    parts.push_back({std::min(size, labelCount + 1), in.number<float>()});
  }
  Vocabulary vocabulary(std::move(labels), std::move(parts));
  if (vocabulary.digest() != digest)
    in.fail("it is damaged (labels and digest disagree)", ErrorCode::corruptFile);
  const auto frameCount = in.number<std::uint64_t>();
  if (frameCount > in.remaining()) in.fail("it is truncated", ErrorCode::truncatedFile);
  std::vector<Frame> frames;
  for (std::uint64_t i = 0; i < frameCount; ++i) frames.push_back(readFrame(in));

  DescriptorMatrix descriptors(vocabulary.size());
  const std::size_t rowBytes = vocabulary.size() * sizeof(float);
  if (in.remaining() / rowBytes != frameCount || in.remaining() % rowBytes != 0)
    in.fail("it is truncated", ErrorCode::truncatedFile);
  descriptors.reserve(frames.size());
  LexicalDescriptor row(vocabulary.size());
  for (const Frame& frame : frames) {
    std::memcpy(row.data(), in.raw(rowBytes).data(), rowBytes);
    requireProbabilities(row, row.size(), fmt::format("{}: {}", io::printable(file), frame.name));
    descriptors.append(row);
  }
  return {printableLabels(vocabulary), std::move(model), std::move(frames), std::move(descriptors)};
}

}  // namespace

OptionGroup declare(DescriptorFileOptions& o) {
  OptionGroup group("descriptor-file", "The files beside a descriptor file.");
  group.add("labels", io::asText(o.labels), "Label file, one label per line")
      .automatic("the labels of the file");
  group.add("frames", io::asText(o.frames), "Names of the rows of a .npy file").automatic("NAME.frames.csv");
  return group;
}

bool isDescriptorFile(const fs::path& file) {
  return io::hasSuffix(file, {".labels", ".csv", ".jsonl", ".ndjson", ".npy"});
}

DescriptorSequence readDescriptors(const fs::path& file, const DescriptorFileOptions& options) {
  if (io::hasSuffix(file, {".labels"})) return readLabelFile(file);
  if (io::hasSuffix(file, {".csv"})) return readCsv(file, options);
  if (io::hasSuffix(file, {".jsonl", ".ndjson"})) return readJsonLines(file, options);
  if (io::hasSuffix(file, {".npy"})) return readNpy(file, options);
  fail(ErrorCode::unsupportedFile,
       "{}: not the extension of a descriptor file; known: .labels, .csv, .jsonl, .ndjson, .npy",
       io::printable(file));
}

void writeDescriptors(const DescriptorSequence& sequence, const fs::path& file) {
  if (io::hasSuffix(file, {".labels"})) return writeLabelFile(sequence, file);
  if (io::hasSuffix(file, {".csv"})) return writeCsv(sequence, file);
  requireDescriptorFile(file);
  writeNpy(sequence, file);
}

std::vector<fs::path> descriptorFilesOf(const fs::path& file) {
  if (!io::hasSuffix(file, {".npy"})) return {file};
  return {file, beside(file, ".labels.txt"), beside(file, ".frames.csv")};
}

void requireDescriptorFile(const fs::path& file) {
  if (!io::hasSuffix(file, {".labels", ".csv", ".npy"}))
    fail(ErrorCode::unsupportedFile, "{}: cannot write this extension; use .labels, .csv or .npy",
         io::printable(file));
}

DescriptorSequence toVocabulary(const DescriptorSequence& sequence, const Vocabulary& vocabulary) {
  // Repeated labels are matched in order: the first to the first, the second to the second.
  const auto numbered = [](const Vocabulary& labels) {
    std::map<std::string, std::size_t> seen;
    std::vector<std::pair<std::string, std::size_t>> names;
    for (const std::string& label : labels.labels()) names.emplace_back(label, seen[label]++);
    return names;
  };
  std::map<std::pair<std::string, std::size_t>, std::size_t> indices;
  for (const auto& name : numbered(vocabulary)) indices.emplace(name, indices.size());
  const auto names = numbered(sequence.vocabulary);
  DescriptorSequence result{vocabulary, sequence.model, sequence.frames, DescriptorMatrix(vocabulary.size())};
  LexicalDescriptor row(vocabulary.size());
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    std::fill(row.begin(), row.end(), 0.0F);
    const DescriptorView own = sequence.descriptors.row(i);
    for (std::size_t k = 0; k < own.size(); ++k)
      if (const auto index = indices.find(names[k]); index != indices.end()) row[index->second] = own[k];
    result.descriptors.append(row);
  }
  return result;
}

}  // namespace estancia
