// SPDX-License-Identifier: Apache-2.0
#include "described.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/plus_names.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/describe/lexical.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/room_words.hpp"
#include "skipped.hpp"

namespace estancia::apps {
namespace {

/// Maps and tables of features know all of their frames: only rooms can be chosen.
Features selected(const Features& features, const SequenceArguments& source) {
  const SequenceOptions& given = source.options;
  if (!given.poses.empty() || !given.rooms.empty() || !given.split.empty())
    throw Error(ErrorCode::invalidOption,
                fmt::format("{} knows the poses and rooms of its frames, and no splits; leave out --poses, "
                            "--rooms and --split",
                            source.path));
  return withRooms(features, given.only);
}

bool isMap(const std::string& path) {
  return isMapFile(path) || path.ends_with(".estancia");
}

/// Parts of the labels that a map or a label file holds.
std::vector<DescriptorPart> partsOfFile(const std::string& path) {
  if (isMap(path)) {
    const MapStore::Identity labels = MapStore::open(path, MapStore::Access::read).identity();
    return partsOfLabels(labels.vocabulary, labels.model);
  }
  return withRows(featuresOf(readDescriptors(path)), {}).parts;
}

/// Without the images that have no label: what is missing is not improbable.
Features withLabels(const Features& all, bool strict) {
  std::vector<std::size_t> kept;
  Skipped skipped("left out");
  for (std::size_t i = 0; i < all.frames.size(); ++i) {
    if (std::ranges::any_of(all.values.row(i), [](float p) { return p > 0; })) {
      kept.push_back(i);
      continue;
    }
    const std::string problem = fmt::format("\"{}\" has no label", all.frames[i].name);
    if (strict) throw Error(ErrorCode::labelerFailure, problem);
    skipped.add(problem);
  }
  if (kept.empty()) throw Error(ErrorCode::insufficientData, "no image has a label");
  return withRows(all, kept);
}

}  // namespace

bool holdsNumbers(const std::string& path) {
  return isMap(path) || isDescriptorFile(path);
}

FeatureSource::FeatureSource(const ModelArguments& arguments)
    : strict_(arguments.stream.strict),
      cache_(arguments.noCache ? nullptr : std::make_unique<LabelCache>()),
      progress_(makeStderrProgress()) {
  options_.labeler = arguments.options;
  options_.cache = cache_.get();
}

Features FeatureSource::features(const SequenceArguments& source, const std::string& descriptor,
                                 const FeatureTableOptions& tables) {
  const auto parts = [&](const Features& all) {
    return descriptor.empty() ? all : withParts(all, splitAtPlus(descriptor));
  };
  if (isMap(source.path)) return parts(selected(featuresOf(readMapDescriptors(source.path)), source));
  if (isFeatureTable(source.path))
    return parts(selected(featuresOf(readFeatureTable(source.path, tables)), source));
  const auto sequence = source.open();
  if (isDescriptorFile(source.path))
    return parts(withLabels(withFramesOf(featuresOf(readDescriptors(source.path)), *sequence), strict_));
  return features(*sequence, descriptor);
}

Features FeatureSource::features(const Sequence& sequence, const std::string& descriptor) {
  std::vector<std::string> problems;
  Features features = describeSequence(sequence, descriptor, options_, *progress_, &problems);
  if (strict_ && !problems.empty()) throw Error(ErrorCode::fileUnreadable, problems.front());
  warn(problems);
  return features;
}

RoomPredictions FeatureSource::rooms(const RoomClassifier& classifier, const DescriptorSequence& labels,
                                     const Sequence* sequence) {
  std::vector<std::string> problems;
  const Features features = featuresFor(classifier, labels, sequence, options_, *progress_, &problems);
  warn(problems);
  RoomPredictions rooms = predictRooms(classifier, features, labels.frames, options_.labeler.threads);
  const double share = shareOfNames(static_cast<double>(classifier.trainingImages()) /
                                    static_cast<double>(classifier.rooms().size()));
  const WordGraph* graph = share > 0 ? installedWordGraph() : nullptr;
  if (graph == nullptr || !knowsRooms(*graph, classifier.rooms())) return rooms;
  spdlog::info("{} images of {} rooms are few examples; what labels tell of the rooms' names counts, too",
               classifier.trainingImages(), classifier.rooms().size());
  return withNames(std::move(rooms),
                   predictRoomsByNames(*graph, labels.vocabulary, labels.descriptors, classifier.rooms()),
                   share);
}

void FeatureSource::warn(const std::vector<std::string>& problems) const {
  Skipped skipped("left out");
  for (const std::string& problem : problems) skipped.add(problem);
  if (cache_ && !cache_->problem().empty()) spdlog::warn("{}", cache_->problem());
}

void addDescribing(DeclaredOptions& declared, ModelArguments& arguments) {
  arguments.addLabelerTo(declared);
  declared.command().add_flag("--no-cache", arguments.noCache,
                              "Label every image again; leave the label cache alone");
  declared.command().add_flag("--strict", arguments.stream.strict,
                              "Stop at an unreadable image instead of skipping it");
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

void addRoomsByNameOption(CLI::App& command, std::vector<std::string>& rooms) {
  command
      .add_option("--rooms-by-name", rooms,
                  "The rooms that there are, separated by commas, in English: told by what labels have to do "
                  "with their names, without any example\n"
                  "Default: common rooms, where at least two labels tell the same one; see `classify name`; "
                  "none by --words raw")
      ->delimiter(',')
      ->type_name("NAME")
      ->excludes("--room-classifier");
}

std::optional<RoomClassifier> openRoomClassifier(const std::string& file, const SequenceArguments& source) {
  if (file.empty()) return std::nullopt;
  RoomClassifier classifier = readRoomClassifier(file);
  if (holdsNumbers(source.path))
    requireParts(classifier, partsOfFile(source.path));
  else
    requireDescribable(classifier, *source.openQuietly());
  return classifier;
}

}  // namespace estancia::apps
