#include "described.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <unordered_map>

#include "estancia/core/error.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/lexical.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/files.hpp"
#include "estancia/topology/map.hpp"
#include "estancia/topology/store.hpp"

namespace estancia::apps {
namespace {

/// The rows of the frames that `sequence` lists: with its rooms and poses, and only those it selects.
Features asListedIn(const Sequence& sequence, const Features& features) {
  std::unordered_map<std::string, std::size_t> rowOf;
  for (std::size_t i = 0; i < features.frames.size(); ++i) rowOf.emplace(features.frames[i].name, i);
  std::vector<std::size_t> rows;
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (const auto row = rowOf.find(sequence.frame(i).name); row != rowOf.end()) {
      rows.push_back(row->second);
      frames.push_back(sequence.frame(i));
    }
  Features listed = withRows(features, rows);
  listed.frames = std::move(frames);
  return listed;
}

/// Maps and tables of features know all of their frames: only rooms can be chosen.
Features chosen(const Features& features, const SequenceArguments& source) {
  const SequenceOptions& given = source.options;
  if (!given.poses.empty() || !given.rooms.empty() || !given.split.empty())
    throw Error(fmt::format(
        "{} knows the poses and rooms of its frames, and no splits; leave out --poses, --rooms and --split",
        source.path));
  if (given.only.empty()) return features;
  std::set<std::string> known;
  for (const Frame& frame : features.frames) known.insert(frame.room);
  known.erase("");
  for (const std::string& room : given.only)
    if (!known.contains(room))
      throw Error(fmt::format("{}: there is no room \"{}\"; known are {}", source.path, room,
                              fmt::join(known, ", ")));
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < features.frames.size(); ++i)
    if (std::ranges::find(given.only, features.frames[i].room) != given.only.end()) rows.push_back(i);
  return withRows(features, rows);
}

/// A CSV that says the room of each line holds numbers that others computed; others hold words.
bool isFeatureTable(const std::string& path) {
  if (!io::hasSuffix(path, {".csv"})) return false;
  std::ifstream file(path);
  constexpr std::size_t longest = std::size_t{1} << 22;
  std::string header(longest, '\0');
  file.getline(header.data(), static_cast<std::streamsize>(longest));
  std::istringstream cells(header.c_str());
  for (std::string cell; std::getline(cells, cell, ',');) {
    std::erase_if(cell, [](char c) { return c == '"' || c == ' ' || c == '\r'; });
    if (cell == "room" || cell == "class") return true;
  }
  return false;
}

bool isMap(const std::string& path) {
  return isMapFile(path) || path.ends_with(".estancia");
}

/// Of the words that a map or a label file holds.
std::vector<DescriptorPart> partsOfFile(const std::string& path) {
  if (isMap(path)) {
    const MapStore::Identity words = MapStore::open(path, MapStore::Access::read).identity();
    return partsOfLabels(words.vocabulary, words.model);
  }
  return withRows(featuresOf(readDescriptors(path)), {}).parts;
}

}  // namespace

bool holdsNumbers(const std::string& path) {
  return isMap(path) || isDescriptorFile(path);
}

FeatureSource::FeatureSource(const ModelArguments& arguments)
    : cache_(arguments.noCache ? nullptr : std::make_unique<LabelCache>()), progress_(makeStderrProgress()) {
  options_.labeler = arguments.options;
  options_.cache = cache_.get();
}

Features FeatureSource::features(const SequenceArguments& source, const std::string& descriptor) {
  const auto parts = [&](const Features& all) {
    return descriptor.empty() ? all : withParts(all, splitAtPlus(descriptor));
  };
  if (isMap(source.path)) return parts(chosen(featuresOf(readMapDescriptors(source.path)), source));
  if (isFeatureTable(source.path)) return parts(chosen(featuresOf(readFeatureTable(source.path)), source));
  const auto sequence = source.open();
  if (isDescriptorFile(source.path))
    return parts(asListedIn(*sequence, featuresOf(readDescriptors(source.path))));
  return features(*sequence, descriptor, source.strict);
}

Features FeatureSource::features(const Sequence& sequence, const std::string& descriptor, bool strict) {
  std::vector<std::string> problems;
  Features features = describeSequence(sequence, descriptor, options_, *progress_, &problems);
  if (strict && !problems.empty()) throw Error(problems.front());
  warn(problems);
  return features;
}

RoomPredictions FeatureSource::rooms(const RoomClassifier& classifier, const DescriptorSequence& words,
                                     const Sequence* sequence) {
  std::vector<std::string> problems;
  const Features features = featuresFor(classifier, words, sequence, options_, *progress_, &problems);
  warn(problems);
  return predictRooms(classifier, features, words.frames, options_.labeler.threads);
}

void FeatureSource::warn(const std::vector<std::string>& problems) const {
  for (const std::string& problem : problems) spdlog::warn("left out: {}", problem);
  if (cache_ && !cache_->problem().empty()) spdlog::warn("{}", cache_->problem());
}

void nameRooms(const std::string& map, const RoomClassifier& classifier, const Sequence* sequence,
               FeatureSource& describing) {
  writeRoomPredictions(describing.rooms(classifier, readMapDescriptors(map), sequence), map);
}

void addRoomClassifierOption(CLI::App& command, std::string& classifier) {
  command
      .add_option("--room-classifier", classifier,
                  "Name the rooms by this room classifier, a file of `estancia classify train`")
      ->type_name("FILE");
}

std::optional<RoomClassifier> openRoomClassifier(const std::string& file, const SequenceArguments& source) {
  if (file.empty()) return std::nullopt;
  RoomClassifier classifier = readRoomClassifier(file);
  if (holdsNumbers(source.path))
    requireParts(classifier, partsOfFile(source.path));
  else
    requireDescribable(classifier, *openSequence(source.path, source.options));
  return classifier;
}

}  // namespace estancia::apps
