// SPDX-License-Identifier: Apache-2.0
#include "words/rooms_by_name.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "estancia/areas/areas.hpp"
#include "estancia/classify/zero_shot_rooms.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/room_words.hpp"
#include "runner/config_lists.hpp"
#include "words/room_answers.hpp"

namespace estancia::experiments {
namespace {

constexpr int roomsByNameVersion = 1;  // version of the code below: cells of another one are computed anew

const std::string blocks = "blocks", areasName = "areas";

Choices groupings() {
  return {{blocks, "images of one room that follow each other"},
          {areasName, "the areas of a drive with depth and poses, as a map names them"}};
}

RoomsByNameOptions::Task readRoomTask(ConfigFile& config, const toml::table& table) {
  RoomsByNameOptions::Task task;
  const auto text = [&config](const toml::node& node) { return config.text(node); };
  config.read(table, {{"name", true, "what to call it", [&](auto& n) { task.name = config.text(n); }},
                      {"only", false, "only images of these rooms", each(config, task.only, text)},
                      {"rooms", false, "the rooms that are listed", each(config, task.rooms, text)}});
  return task;
}

/// What one task asks about.
struct AskedImages {
  std::vector<Frame> frames;
  DescriptorMatrix labels;
  /// Numbers of the drive's labeled frames.
  std::vector<std::size_t> numbers;
};

AskedImages imagesOfTask(const DescriptorSequence& recording, const RoomsByNameOptions::Task& task) {
  AskedImages asked{{}, DescriptorMatrix(recording.vocabulary.size()), {}};
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    if (!task.only.empty() && std::ranges::find(task.only, recording.frames[i].room) == task.only.end())
      continue;
    asked.frames.push_back(recording.frames[i]);
    asked.labels.append(recording.descriptors.row(i));
    asked.numbers.push_back(i);
  }
  return asked;
}

/// Areas are the same for all tasks of a drive, and the longest part.
class AreasOfDrives {
 public:
  const std::vector<int>& of(const LabeledDrive& drive, const std::string& name) {
    const auto key = std::pair(drive.recording.model, name);
    auto known = areas_.find(key);
    if (known == areas_.end())
      known = areas_.emplace(key, findAreas(*drive.images, drive.recording).zones.zoneOf).first;
    return known->second;
  }

 private:
  std::map<std::pair<std::string, std::string>, std::vector<int>> areas_;
};

std::vector<GroupAnswer> nameAreasOf(const RoomPredictions& predictions, const AskedImages& asked,
                                     const std::vector<int>& areas) {
  std::vector<int> areaOf;
  for (const std::size_t number : asked.numbers) areaOf.push_back(areas[number]);
  return nameAreaGroups(predictions, groupsOfAreas(asked.frames, areaOf));
}

/// Each area by itself: there are few.
void addAreas(const std::vector<GroupAnswer>& areas, CellResults& results) {
  for (std::size_t a = 0; a < areas.size(); ++a) {
    const GroupAnswer& area = areas[a];
    if (area.images == 0) continue;
    const std::string at = fmt::format("area {} in {}: {}", a, area.truth.empty() ? "no room" : area.truth,
                                       area.isSure ? area.answer : "no name, rather " + area.answer);
    results.push_back({"images", at, static_cast<double>(area.images)});
    results.push_back({"probability", at, area.probability});
  }
}

std::string describeTask(const RoomsByNameOptions& options, const RoomsByNameOptions::Task& task,
                         const WordGraph& graph) {
  return fmt::format(
      "{} {} {} {} {} {} {}", roomsByNameVersion, options.groups, options.block, fmt::join(task.only, ","),
      fmt::join(task.rooms.empty() ? commonRooms() : task.rooms, ","), task.rooms.empty(), graph.degreeSum);
}

}  // namespace

RoomsByNameOptions readRoomsByName(ConfigFile& config) {
  RoomsByNameOptions options;
  const toml::array *tasks = nullptr, *data = nullptr;
  const auto grouping = oneOf(config, groupings());
  config.read(
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"models", false, "the models whose labels tell",
        each(config, options.models, [&config](auto& n) { return config.text(n); })},
       {"groups", false, "which images are named together", [&](auto& n) { options.groups = grouping(n); }},
       {"block", false, "images in a block",
        [&](auto& n) { options.block = static_cast<int>(config.integer(n, 1, 100000)); }},
       {"task", true, "[[task]] lists rooms", [&](auto& n) { tasks = &config.list(n); }},
       {"data", true, "[[data]] names images with rooms", [&](auto& n) { data = &config.list(n); }}});
  for (const toml::node& node : *tasks) {
    options.tasks.push_back(readRoomTask(config, config.subtable(node)));
    for (std::size_t t = 0; t + 1 < options.tasks.size(); ++t)
      if (options.tasks[t].name == options.tasks.back().name)
        config.fail(node, fmt::format("two tasks are called {}", options.tasks[t].name));
  }
  for (const toml::node& node : *data)
    options.drives.push_back(readNamedDrive(config, config.subtable(node)));
  return options;
}

GridColumns roomsByNameColumns() {
  return {{"model", "data", "task"},
          "of",
          {"images", "chance", "accuracy", "accuracy_low", "accuracy_high", "groups", "pooled_accuracy",
           "pooled_low", "pooled_high", "sure", "sure_accuracy", "probability"}};
}

Findings nameRooms(const RoomsByNameOptions& options, Grid& grid, const ExperimentRun& run,
                   Progress& progress) {
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) throw Error(ErrorCode::missingDependency, wordNetHint());
  std::vector<std::string> tasks;
  for (const RoomsByNameOptions::Task& task : options.tasks) tasks.push_back(task.name);
  AreasOfDrives areas;
  const auto inputs = [&](const NamedDrive&, std::size_t task) {
    return describeTask(options, options.tasks[task], *graph);
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t t) {
    const LabeledDrive& known = labeled.of(drive.images);
    const RoomsByNameOptions::Task& task = options.tasks[t];
    const AskedImages asked = imagesOfTask(known.recording, task);
    if (asked.frames.empty())
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{}: no image is in one of the rooms of the task {}", drive.name, task.name));
    const RoomPredictions predictions =
        predictRoomsByNames(*graph, known.recording.vocabulary, asked.labels, task.rooms);
    const bool byArea = options.groups == areasName;
    const std::vector<GroupAnswer> groups =
        byArea
            ? nameAreasOf(predictions, asked, areas.of(known, drive.name))
            : nameBlocks(predictions, blocksOfRooms(asked.frames, static_cast<std::size_t>(options.block)));
    CellResults results = measureRoomAnswers(predictions, asked.frames, groups);
    if (byArea) addAreas(groups, results);
    return results;
  };
  return studyDrives({options.models, options.drives, tasks, inputs, compute}, roomsByNameFindings, grid, run,
                     progress);
}

}  // namespace estancia::experiments
