// SPDX-License-Identifier: Apache-2.0
#include "runner/experiment.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <variant>

#include "estancia/classify/classifier.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "features/feature_study.hpp"
#include "objects/home_known_objects.hpp"
#include "objects/home_objects.hpp"
#include "objects/home_segmentation.hpp"
#include "objects/home_worlds.hpp"
#include "objects/object_segmentation.hpp"
#include "objects/object_splits.hpp"
#include "odometry/odometry_errors.hpp"
#include "places/further_drives.hpp"
#include "places/localization_errors.hpp"
#include "places/maps.hpp"
#include "places/missing_labels.hpp"
#include "places/model_choice.hpp"
#include "places/place_tasks.hpp"
#include "places/revisits.hpp"
#include "places/room_agreement.hpp"
#include "places/tours.hpp"
#include "places/word_positions.hpp"
#include "recognition/bop.hpp"
#include "recognition/color_recognition.hpp"
#include "recognition/known_objects.hpp"
#include "recognition/recognition.hpp"
#include "runner/grid.hpp"
#include "scenes/scenes.hpp"
#include "words/few_examples.hpp"
#include "words/rooms_by_name.hpp"
#include "words/words_experiment.hpp"
#include "zones/zone_tables.hpp"

namespace estancia::experiments {
namespace {

/// What a configuration asks for, read and checked.
struct Experiment {
  std::vector<std::vector<std::string>> cells;  // coordinates of those that are sure to be; may be empty
  std::function<Findings(Grid& grid, const ExperimentRun& run, Progress& progress)> run;
};

/// Cells of the sequences that are there, and of descriptors that are not optional.
std::vector<std::vector<std::string>> scenesCells(const ScenesOptions& options) {
  std::vector<std::pair<std::string, std::string>> pairs;
  std::vector<std::string> sequences, classifiers = options.classifiers;
  for (const ScenesOptions::Data& data : options.data) {
    if (data.optional && !std::filesystem::exists(data.images.path)) continue;
    if (data.asked || !data.splitColumn.empty())
      pairs.emplace_back(data.name + " train", data.name + " test");
    else
      sequences.push_back(data.name);
  }
  for (const std::string& train : sequences)
    for (const std::string& test : sequences)
      if (train != test || options.sameSequence) pairs.emplace_back(train, test);
  if (classifiers.empty())
    for (const auto& [type, explanation] : classifierTypes()) classifiers.push_back(type);
  std::vector<std::vector<std::string>> cells;
  for (const std::string& descriptor : options.descriptors)
    for (const std::string& classifier : classifiers)
      for (const auto& [train, test] : pairs) cells.push_back({descriptor, classifier, train, test});
  return cells;
}

template <class Options>
std::vector<std::vector<std::string>> sureCells(const Options&) {
  return {};
}

template <>
std::vector<std::vector<std::string>> sureCells(const ScenesOptions& options) {
  return scenesCells(options);
}

template <auto readOptions, auto findings>
Experiment prepare(ConfigFile& config) {
  const auto options = readOptions(config);
  return {sureCells(options), [options](Grid& grid, const ExperimentRun& run, Progress& progress) {
            return findings(options, grid, run, progress);
          }};
}

struct Kind {
  const char* type;
  const char* explanation;
  GridColumns (*columns)();
  bool cellsLabel;  // then they are computed one by one: the threads belong to the network
  Experiment (*read)(ConfigFile& config);
};

constexpr Kind kindTable[] = {
    {"bop", "known objects in data sets of the BOP challenge, by its measures", bopColumns, false,
     prepare<readBopOptions, compareWithBop>},
    {"color-recognition", "known objects by shape and by color, where shape is ambiguous and where it is not",
     colorRecognitionColumns, false, prepare<readColorRecognition, compareColors>},
    {"features", "places by words, by inner layers of networks and by image features (thesis 4.6)",
     featureStudyColumns, true, prepare<readFeatureStudy, compareFeatures>},
    {"few-examples", "rooms by a few images of each, by their names alone, and by both", fewExamplesColumns,
     true, prepare<readFewExamples, learnFromFew>},
    {"further-drives", "drives that follow another one: recognized in its map, continued and merged",
     furtherDrivesColumns, true, prepare<readFurtherDrives, compareFurtherDrives>},
    {"home-known-objects", "things of one drive through a home, looked for in the map of another",
     homeKnownObjectsColumns, true, prepare<readHomeKnownObjects, findHomeKnownObjects>},
    {"home-objects",
     "things of a furnished home in its map, each as one instance, and instances that are none",
     homeObjectColumns, false, prepare<readHomeSegmentation, findHomeObjects>},
    {"home-segmentation", "things of a furnished home found by class, and clusters that are none",
     homeSegmentationColumns, false, prepare<readHomeSegmentation, segmentHomes>},
    {"home-world", "whole maps of drives through a home: areas, trajectory, objects and their names",
     homeWorldsColumns, true, prepare<readHomeWorlds, mapHomeWorlds>},
    {"known-objects", "made-up models put into real depth frames, and such as are not there",
     knownObjectsColumns, false, prepare<readKnownObjects, compareKnownObjects>},
    {"localization", "one drive found in the map of another, by each image alone and by all so far",
     localizationErrorsColumns, true, prepare<readLocalizationErrors, compareLocalization>},
    {"maps", "maps side by side over thresholds, and images found in one of them (thesis 4.5.3)", mapsColumns,
     true, prepare<readMaps, compareMaps>},
    {"missing-labels", "places and rooms by a labeler that returns its best labels only (thesis 3.4.2, 3.7)",
     missingLabelsColumns, true, prepare<readMissingLabels, compareMissingLabels>},
    {"model-choice", "which model's labels separate places best (thesis 4.5.2)", modelChoiceColumns, false,
     prepare<readModelChoice, chooseModel>},
    {"object-segmentation", "objects in images, over- and under-segmentation (thesis 6.3)",
     objectSegmentationColumns, false, prepare<readObjectSegmentation, segmentObjects>},
    {"object-splits", "shapes learned from a labeler's pseudo-labels, tested on other objects (thesis 6.4)",
     objectSplitsColumns, false, prepare<readObjectSplits, splitObjects>},
    {"odometry", "camera trajectories beside the true ones, with noise and with fewer frames",
     odometryErrorsColumns, true, prepare<readOdometryErrors, compareOdometry>},
    {"places", "mapping, localization and room classification, model by model", placeTasksColumns, true,
     prepare<readPlaceTasks, comparePlaceTasks>},
    {"recognition", "known objects in noisy scenes, by filter, keypoints and descriptor (thesis 2.6)",
     recognitionColumns, false, prepare<readRecognition, compareRecognition>},
    {"revisits", "returns to mapped places: found, missed and wrong, with poses and by words alone",
     revisitsColumns, true, prepare<readRevisits, compareRevisits>},
    {"room-agreement", "places and zones of drives against the rooms stood in and the rooms seen",
     roomAgreementColumns, true, prepare<readRoomAgreement, compareWithRooms>},
    {"rooms-by-name", "rooms of images and areas by the rooms' names alone, without an example",
     roomsByNameColumns, true, prepare<readRoomsByName, nameRooms>},
    {"scenes", "room classification, every descriptor with every classifier (thesis 3.5)", scenesColumns,
     false, prepare<readScenes, compareScenes>},
    {"tours", "places of tours through two rooms and many, visited once and often", toursColumns, true,
     prepare<readTours, mapTours>},
    {"word-map", "words on the floor beside the things that they name", wordPositionsColumns, true,
     prepare<readWordPositions, compareWordPositions>},
    {"words", "labels found by the words of people, by matching names and by relatedness", wordsColumns,
     false, prepare<readWords, compareWords>},
    {"zones", "zones against rooms, by model, distance, linkage and cut (thesis 5.5)", zoneTablesColumns,
     false, prepare<readZoneTables, compareZones>},
};

template <class T>
void addNew(std::vector<T>& to, const std::vector<T>& from) {
  for (const T& one : from)
    if (std::find(to.begin(), to.end(), one) == to.end()) to.push_back(one);
}

/// Refuses, before anything is computed, what would be found twice or replace what another has written.
void requireDifferent(const std::vector<std::filesystem::path>& configs,
                      const std::vector<Experiment>& experiments) {
  std::map<std::vector<std::string>, std::size_t> known;
  for (std::size_t i = 0; i < configs.size(); ++i) {
    const std::string here = configs[i].string();
    for (const auto& cell : experiments[i].cells) {
      const auto [other, isNew] = known.emplace(cell, i);
      if (!isNew && other->second != i)
        throw Error(ErrorCode::invalidInput,
                    fmt::format("{} and {} both ask for {}; leave it out of one, or run them one by one into "
                                "folders of their own (-o)",
                                configs[other->second].string(), here, fmt::join(cell, ", ")));
    }
    for (std::size_t j = 0; j < i; ++j)
      if (!experiments[i].cells.empty() && configs[j].stem() == configs[i].stem())
        throw Error(ErrorCode::invalidInput,
                    fmt::format("{} and {} have the same name, by which their tables are called; rename one",
                                configs[j].string(), here));
  }
}

/// Adds what was found next. What all print beside their own, as the thesis' tables, comes once and last.
void append(Findings& all, Findings findings) {
  all.summary += (all.summary.empty() ? "" : " ") + findings.summary;
  addNew(all.facts, findings.facts);
  addNew(all.notes, findings.notes);
  for (Findings& part : findings.apart) all.apart.push_back(std::move(part));
  for (auto& section : findings.sections) {
    if (const auto* table = std::get_if<ResultTable>(&section))
      std::erase_if(all.sections, [table](const auto& known) {
        const auto* other = std::get_if<ResultTable>(&known);
        return other != nullptr && *other == *table;
      });
    all.sections.push_back(std::move(section));
  }
}

/// Experiments of one type, in one folder.
struct Group {
  const Kind* kind;
  std::vector<std::filesystem::path> configs = {};
  std::vector<Experiment> experiments = {};

  Findings run(const ExperimentRun& run, Progress& progress) const {
    Grid grid(run.folder, kind->columns(), kind->cellsLabel ? 1 : run.labeler.threads, run.distribution);
    grid.makeFolder();
    Findings all;
    for (std::size_t i = 0; i < experiments.size(); ++i) {
      grid.setSource(configs[i].string());
      Findings findings = experiments[i].run(grid, run, progress);
      all.title = findings.title;
      append(all, std::move(findings));
    }
    grid.writeCsv();
    return all;
  }
};

std::vector<Group> readGroups(const std::vector<std::filesystem::path>& configs) {
  std::vector<std::pair<std::string, const Kind*>> kinds;
  for (const Kind& kind : kindTable) kinds.emplace_back(kind.type, &kind);
  std::vector<Group> groups;
  for (const auto& file : configs) {
    ConfigFile config(file);
    const Kind* kind = nullptr;
    const auto choose = [&](const toml::node& node) { kind = config.choice(node, kinds); };
    config.read({{"type", true, "the kind of experiment, as \"model-choice\"", choose}},
                ConfigFile::Others::skip);
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.kind == kind; });
    if (group == groups.end()) group = groups.insert(group, {kind});
    group->configs.push_back(file);
    group->experiments.push_back(kind->read(config));
  }
  if (groups.empty()) throw Error(ErrorCode::insufficientData, "no experiment is named");
  for (const Group& group : groups) requireDifferent(group.configs, group.experiments);
  return groups;
}

}  // namespace

void checkExperiments(const std::vector<std::filesystem::path>& configs) {
  readGroups(configs);
}

Findings runExperiment(const std::vector<std::filesystem::path>& configs, const ExperimentRun& run,
                       Progress& progress) {
  const std::vector<Group> groups = readGroups(configs);
  if (groups.size() == 1) return groups[0].run(run, progress);

  for (const Group& group : groups) Grid(run.folder / group.kind->type, {}).makeFolder();
  Findings all;
  for (const Group& group : groups) {
    ExperimentRun own = run;
    own.folder /= group.kind->type;
    Findings findings = group.run(own, progress);
    for (Findings& part : findings.apart) part.file = std::string(group.kind->type) + "/" + part.file;
    all.title += (all.title.empty() ? "" : " · ") + findings.title;
    append(all, std::move(findings));
  }
  return all;
}

Choices experimentTypes() {
  Choices types;
  for (const Kind& kind : kindTable) types.push_back({kind.type, kind.explanation});
  return types;
}

}  // namespace estancia::experiments
