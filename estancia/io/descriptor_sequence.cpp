#include "estancia/io/descriptor_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/io/csv.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/frame_list.hpp"
#include "estancia/io/label_file.hpp"
#include "estancia/io/label_scores.hpp"
#include "estancia/io/npy.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

std::string at(const fs::path& file, std::size_t line) {
  return fmt::format("{}:{}", io::printable(file.string()), line);
}

std::optional<Vocabulary> givenWords(const DescriptorFileOptions& options) {
  if (options.labels.empty()) return std::nullopt;
  return readVocabulary(options.labels);
}

DescriptorSequence recordingOf(const fs::path& file, Vocabulary vocabulary, std::vector<Frame> frames,
                               DescriptorMatrix descriptors) {
  if (frames.empty()) throw Error(fmt::format("{}: no images in it", io::printable(file.string())));
  // Nothing in such a file says who spoke. Those who use the same words are taken for the same, so that one
  // recording can be found in the map of another.
  std::string model = "recorded " + vocabulary.digest();
  return {std::move(vocabulary), std::move(model), std::move(frames), std::move(descriptors)};
}

Frame named(std::string name) {
  Frame frame;
  frame.name = std::move(name);
  return frame;
}

/// Images whose words come one by one; a row of numbers is made of them at the end.
class SparseRows {
 public:
  explicit SparseRows(const DescriptorFileOptions& options) {
    if (auto vocabulary = givenWords(options)) book_ = io::WordBook(std::move(*vocabulary));
  }

  void add(std::string image, std::vector<LabelProbability> words, const std::string& source) {
    frames_.push_back(named(std::move(image)));
    places_.push_back(book_.place(std::move(words), 0, source));
  }

  DescriptorSequence finish(const fs::path& file) {
    // Few bytes can name many images and many words, whose product is what memory must hold.
    constexpr std::size_t most = 500'000'000;
    if (!frames_.empty() && book_.size() > most / frames_.size())
      throw Error(
          fmt::format("{}: {} images × {} words are more than the {} numbers that are read; give a "
                      "label file with the words that matter",
                      io::printable(file.string()), frames_.size(), book_.size(), most));
    if (frames_.empty()) throw Error(fmt::format("{}: no images in it", io::printable(file.string())));
    if (book_.size() == 0) throw Error(fmt::format("{}: no words in it", io::printable(file.string())));
    DescriptorMatrix descriptors(book_.size());
    descriptors.reserve(frames_.size());
    for (const auto& places : places_) descriptors.append(book_.toDescriptor(places));
    return recordingOf(file, book_.vocabulary(), std::move(frames_), std::move(descriptors));
  }

 private:
  io::WordBook book_;
  std::vector<Frame> frames_;
  std::vector<io::WordBook::Places> places_;
};

double numberOf(const std::string& cell, const std::string& label, const std::string& where) {
  const auto value = io::toNumber(cell);
  if (!value)
    throw Error(fmt::format("{}: \"{}\" is no number for \"{}\"", where, io::printable(cell), label));
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
      if (labels.empty()) throw Error(fmt::format("{}: no labels in the header `image,LABEL,…`", where));
      descriptors.emplace(labels.size());
      values.resize(labels.size());
      return;
    }
    if (row.cells.size() != labels.size() + 1)
      throw Error(fmt::format("{}: {} cells where the header has {}; is the file cut short?", where,
                              row.cells.size(), labels.size() + 1));
    std::string image = io::printable(row.cells[0]);
    names.add(image, file, row.line);
    for (std::size_t i = 0; i < labels.size(); ++i)
      values[i] = io::toProbability(numberOf(row.cells[i + 1], labels[i], where), labels[i], where);
    frames.push_back(named(std::move(image)));
    descriptors->append(values);
  });
  Vocabulary vocabulary(std::move(labels));
  if (const auto given = givenWords(options))
    requireSameVocabulary(*given, vocabulary, io::printable(file.string()));
  return recordingOf(file, std::move(vocabulary), std::move(frames), std::move(*descriptors));
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
      throw Error(fmt::format("{}: {} cells; a line is `image,label,probability`", where, row.cells.size()));
    std::string image = io::printable(row.cells[0]), label = io::toLabel(row.cells[1], where);
    if (image.empty()) throw Error(fmt::format("{}: the image has no name", where));
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
    rows.add(std::move(images[i]), std::move(words[i]), io::printable(file.string()));
  return rows.finish(file);
}

/// The header tells the wide from the long form.
DescriptorSequence readCsvRecording(const fs::path& file, const DescriptorFileOptions& options) {
  std::ifstream stream(file);
  if (!fs::is_regular_file(file) || !stream)
    throw Error(fmt::format("{}: no file that can be read", io::printable(file.string())));
  std::string start(256, '\0');
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream.gcount()));
  if (start.starts_with("\xEF\xBB\xBF")) start.erase(0, 3);
  std::erase_if(start, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; });
  const std::string header = start.substr(0, start.find('\n'));
  if (header == "image,label,probability" || header == "image,label,confidence")
    return readLongCsv(file, options);
  if (header.starts_with("image,")) return readWideCsv(file, options);
  throw Error(fmt::format("{}: no header; the first line is `image,LABEL,…` or `image,label,probability`",
                          at(file, 1)));
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
  const std::string name = io::printable(file.string());
  const fs::path labels = options.labels.empty() ? beside(file, ".labels.txt") : options.labels;
  if (!fs::is_regular_file(labels))
    throw Error(fmt::format("{}: its {} columns have no names; write them, one a line, into {}", name,
                            matrix.columns(), io::printable(labels.string())));
  Vocabulary vocabulary = readVocabulary(labels);
  if (vocabulary.size() != matrix.columns())
    throw Error(fmt::format("{} has {} columns, but {} has {} labels; use the label file that belongs to it",
                            name, matrix.columns(), io::printable(labels.string()), vocabulary.size()));
  fs::path list = options.frames;
  if (list.empty() && fs::exists(beside(file, ".frames.csv"))) list = beside(file, ".frames.csv");
  std::vector<Frame> frames;
  if (!list.empty()) frames = io::readFrameList(list);
  for (std::size_t i = 0; list.empty() && i < matrix.rows(); ++i)
    frames.push_back(named(fmt::format("frame {:06}", i)));
  if (frames.size() != matrix.rows())
    throw Error(fmt::format("{} has {} rows, but {} names {} images", name, matrix.rows(),
                            io::printable(list.string()), frames.size()));
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
  return recordingOf(file, std::move(vocabulary), std::move(frames), std::move(descriptors));
}

}  // namespace

bool isDescriptorFile(const fs::path& file) {
  return io::hasSuffix(file, {".labels", ".csv", ".jsonl", ".ndjson", ".npy"});
}

DescriptorSequence readDescriptors(const fs::path& file, const DescriptorFileOptions& options) {
  if (io::hasSuffix(file, {".labels"})) return io::readLabelFile(file);
  if (io::hasSuffix(file, {".csv"})) return readCsvRecording(file, options);
  if (io::hasSuffix(file, {".jsonl", ".ndjson"})) return readJsonLines(file, options);
  if (io::hasSuffix(file, {".npy"})) return readNpy(file, options);
  throw Error(
      fmt::format("{}: no kind of recording that is known; known are .labels, .csv, .jsonl, .ndjson and .npy",
                  io::printable(file.string())));
}

void writeDescriptors(const DescriptorSequence& recording, const fs::path& file) {
  if (io::hasSuffix(file, {".labels"})) return io::writeLabelFile(recording, file);
  if (io::hasSuffix(file, {".csv"})) return writeCsv(recording, file);
  requireRecordingName(file);
  writeNpy(recording, file);
}

std::vector<fs::path> filesOfRecording(const fs::path& file) {
  if (!io::hasSuffix(file, {".npy"})) return {file};
  return {file, beside(file, ".labels.txt"), beside(file, ".frames.csv")};
}

void requireRecordingName(const fs::path& file) {
  if (!io::hasSuffix(file, {".labels", ".csv", ".npy"}))
    throw Error(fmt::format("{}: labels are written as NAME.labels, NAME.csv or NAME.npy; choose one of them",
                            io::printable(file.string())));
}

DescriptorSequence inWordsOf(const Vocabulary& vocabulary, const DescriptorSequence& recording) {
  // A label that stands there more than once: the first is the other's first, the second its second.
  const auto numbered = [](const Vocabulary& words) {
    std::map<std::string, std::size_t> seen;
    std::vector<std::pair<std::string, std::size_t>> names;
    for (const std::string& label : words.labels()) names.emplace_back(label, seen[label]++);
    return names;
  };
  std::map<std::pair<std::string, std::size_t>, std::size_t> places;
  for (const auto& name : numbered(vocabulary)) places.emplace(name, places.size());
  const auto names = numbered(recording.vocabulary);
  DescriptorSequence result{vocabulary, recording.model, recording.frames,
                            DescriptorMatrix(vocabulary.size())};
  LexicalDescriptor row(vocabulary.size());
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    std::fill(row.begin(), row.end(), 0.0F);
    const DescriptorView words = recording.descriptors.row(i);
    for (std::size_t k = 0; k < words.size(); ++k)
      if (const auto place = places.find(names[k]); place != places.end()) row[place->second] = words[k];
    result.descriptors.append(row);
  }
  return result;
}

void writeCsv(const DescriptorSequence& recording, const fs::path& file) {
  std::string text = "image";
  for (const auto& label : recording.vocabulary.labels()) text += ',' + io::csvCell(label);
  text += '\n';
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    text += io::csvCell(recording.frames[i].name);
    for (const float p : recording.descriptors.row(i)) fmt::format_to(std::back_inserter(text), ",{}", p);
    text += '\n';
  }
  writeWhole(file, text);
}

void writeNpy(const DescriptorSequence& recording, const fs::path& file) {
  if (!io::hasSuffix(file, {".npy"}))
    throw Error(fmt::format("{}: a NumPy file is called NAME.npy", io::printable(file.string())));
  std::string labels;
  for (const auto& label : recording.vocabulary.labels()) labels += label + '\n';
  writeWhole(beside(file, ".labels.txt"), labels);
  writeWhole(beside(file, ".frames.csv"), io::frameListText(recording.frames));
  writeWhole(file, io::npyBytes(recording.descriptors));  // last: it is the one that people look for
}

}  // namespace estancia
