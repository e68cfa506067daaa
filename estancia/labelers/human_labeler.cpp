// Human labeler: images labeled by hand, in a CSV file; declared in recorded_labeler.hpp.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "estancia/core/config.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/label_scores.hpp"
#include "estancia/labelers/black_box.hpp"
#include "estancia/labelers/model_files.hpp"
#include "estancia/labelers/recorded_labeler.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// The labels of one image with their confidences; none where the labels share.
struct ImageLabels {
  std::string name;
  std::map<std::string, std::pair<std::optional<float>, std::size_t>> labels;  ///< with their lines
};

std::vector<std::string> splitLabels(std::string_view cell, const std::string& where) {
  std::vector<std::string> labels;
  while (!cell.empty()) {
    const auto end = std::min(cell.find(';'), cell.size());
    labels.push_back(io::toLabel(cell.substr(0, end), where));
    cell.remove_prefix(std::min(end + 1, cell.size()));
  }
  if (labels.empty())
    fail(ErrorCode::malformedFile, "{}: no label; leave the line out if there is none", where);
  return labels;
}

std::vector<ImageLabels> readLabels(const fs::path& file) {
  std::vector<ImageLabels> all;
  std::unordered_map<std::string, std::size_t> indices;
  std::size_t columns = 0;
  io::forEachCsvRow(file, [&](io::CsvRow& row) {
    const std::string where = fmt::format("{}:{}", io::printable(file.string()), row.line);
    const bool first = columns == 0;
    if (first) columns = row.cells.size();
    if ((columns != 2 && columns != 3) || row.cells.size() != columns)
      fail(ErrorCode::malformedFile,
           "{}: {} cells; all lines are `image,label;label2`, or all are `image,label,confidence` (labels "
           "with commas in quotes)",
           where, row.cells.size());
    if (first && row.cells[0] == "image" && row.cells[1].starts_with("label")) return;  // header
    const std::string image = io::printable(row.cells[0]);
    if (image.empty()) fail(ErrorCode::malformedFile, "{}: the image has no name", where);
    const auto [entry, isNew] = indices.emplace(image, all.size());
    if (isNew) all.push_back({image, {}});
    auto& labels = all[entry->second].labels;
    for (const std::string& label :
         columns == 2 ? splitLabels(row.cells[1], where) : std::vector{io::toLabel(row.cells[1], where)}) {
      std::optional<float> confidence;
      if (columns == 3) {
        const auto value = io::toNumber(row.cells[2]);
        if (!value)
          fail(ErrorCode::malformedFile, "{}: \"{}\" is no number for \"{}\"", where,
               io::printable(row.cells[2]), label);
        confidence = io::toProbability(*value, label, where);
      }
      const auto [added, isFresh] = labels.emplace(label, std::pair{confidence, row.line});
      if (!isFresh && added->second.first != confidence)
        fail(ErrorCode::malformedFile, "{}: \"{}\" has another confidence in line {}; keep one of them",
             where, label, added->second.second);
    }
  });
  if (all.empty())
    fail(ErrorCode::insufficientData, "{}: no labeled images in it", io::printable(file.string()));
  return all;
}

Vocabulary sortedLabels(const std::vector<ImageLabels>& all) {
  std::set<std::string> labels;
  for (const ImageLabels& image : all)
    for (const auto& [label, unused] : image.labels) labels.insert(label);
  return Vocabulary({labels.begin(), labels.end()});
}

}  // namespace

DescriptorSequence readHumanLabels(const fs::path& file, const std::optional<Vocabulary>& given,
                                   double certainty) {
  if (!(certainty > 0 && certainty <= 1))
    fail(ErrorCode::invalidOption, "certainty = {}: give a number above 0, at most 1", certainty);
  const std::string name = io::printable(file.string());
  const auto all = readLabels(file);
  const Vocabulary vocabulary = given ? *given : sortedLabels(all);
  std::unordered_map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < vocabulary.size(); ++i) places.emplace(vocabulary[i], i);

  // the limit of recordings: two short lists make a large product
  constexpr std::size_t maxNumbers = 500'000'000;
  if (vocabulary.size() > maxNumbers / all.size())
    fail(ErrorCode::tooLarge, "{}: {} images × {} labels are more than the {} numbers that are read", name,
         all.size(), vocabulary.size(), maxNumbers);
  DescriptorSequence recording{vocabulary, name, {}, DescriptorMatrix(vocabulary.size())};
  recording.descriptors.reserve(all.size());
  for (const ImageLabels& image : all) {
    LexicalDescriptor words(vocabulary.size(),
                            static_cast<float>((1 - certainty) / static_cast<double>(vocabulary.size())));
    for (const auto& [label, how] : image.labels) {
      const auto place = places.find(label);
      if (place == places.end())
        fail(ErrorCode::unknownName, "{}:{}: \"{}\" is not in the label file; correct it there or here", name,
             how.second, label);
      const double share =
          how.first ? static_cast<double>(*how.first) : 1.0 / static_cast<double>(image.labels.size());
      words[place->second] += static_cast<float>(certainty * share);
    }
    for (float& p : words) p = std::min(p, 1.0F);  // by rounding
    Frame frame;
    frame.name = image.name;
    recording.frames.push_back(std::move(frame));
    recording.descriptors.append(words);
  }
  return recording;
}

std::unique_ptr<Labeler> openHuman(const ModelSpec& spec) {
  ConfigFile config(spec.folder / "model.toml");
  fs::path file;
  double certainty = 0.95;
  readBlackBox(config, {{"file", true, "the labeled CSV", [&](auto& n) { file = config.inside(n); }},
                        {"certainty", false, "how sure the person is",
                         [&](auto& n) { certainty = config.number(n, 0.01, 1); }}});
  std::optional<Vocabulary> given;
  if (!spec.labels.empty()) given = readVocabulary(modelFile(spec, spec.labels));
  DescriptorSequence recording = readHumanLabels(modelFile(spec, file), given, certainty);
  recording.model = blackBoxIdentity(spec, config, {file});
  return std::make_unique<RecordedLabeler>(std::move(recording));
}

}  // namespace estancia
