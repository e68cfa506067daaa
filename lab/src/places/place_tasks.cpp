// SPDX-License-Identifier: Apache-2.0
#include "places/place_tasks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/query/accuracy.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/stats/label_scale.hpp"
#include "findings/pivot.hpp"
#include "places/mapped_drive.hpp"
#include "places/room_table.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int placeTasksVersion = 2;  // version of the code below: cells of another one are computed anew
constexpr auto largest = ResultTable::Best::largest;
const std::vector<std::pair<std::string, ResultTable::Column>> measures{
    {"nodes", {"nodes", 0}},
    {"v_measure", {"V-measure", 3, largest}},
    {"one_image", {"one image", 3, largest}},
    {"filtered", {"filtered", 3, largest}},
    {"smoothed", {"smoothed", 3, largest}},
    {"nearest_neighbor", {"nearest neighbor", 3, largest}},
    {"halves_exchanged", {"halves exchanged", 3, largest}}};
constexpr std::size_t smoothing = 20;  // frames of lookahead

/// One task of the configuration, ready for every model.
struct Task {
  std::string name, inputs;  // inputs: a digest of what is not the model
  const PlaceTasksOptions::Drive* drive = nullptr;
  const PlaceTasksOptions::Rooms* rooms = nullptr;
};

/// Labels sequences of one model.
using Recorder = std::function<DescriptorSequence(const Sequence&)>;

CellResults drive(const Task& task, const Recorder& recorder, const fs::path& scratch) {
  const auto images = openImages(task.drive->images);
  const auto again = openImages(task.drive->again);
  const auto recorded = [&](const Sequence& sequence) {
    return task.drive->imagesAlone ? withoutPoses(recorder(sequence)) : recorder(sequence);
  };
  const ScratchMap file(recorded(*images), scratch);
  const auto map =
      std::make_shared<const LocalizerMap>(readLocalizerMap(file.path(), LocalizerOptions{}.maxImages));
  const DescriptorSequence queries = recorded(*again);
  const AdmissibleImages truth =
      task.drive->truth.empty() ? AdmissibleImages{} : readAdmissibleImages(task.drive->truth);
  CellResults results;
  const MapQuality quality = evaluate(map->map);
  results.push_back({"nodes", "", static_cast<double>(quality.nodes)});
  if (quality.rooms) results.push_back({"v_measure", "", quality.rooms->vMeasure});
  const auto add = [&](const char* measure, const Accuracy& accuracy) {
    if (const auto& share = accuracy.recall ? accuracy.recall : accuracy.room)
      results.push_back({measure, "", *share});
  };
  const LocalizationAccuracy filtered = findDrive(queries, map, 0, truth);
  add("one_image", filtered.nearestImage);
  add("filtered", filtered.belief);
  add("smoothed", findDrive(queries, map, smoothing, truth).belief);
  return results;
}

/// Which images of the sequence belong to which room and half.
struct Halves {
  std::vector<std::size_t> train, test;
  std::vector<std::string> rooms;  // rooms of every image
};

Halves readHalves(const PlaceTasksOptions::Rooms& rooms, const std::vector<Frame>& frames) {
  const RoomTable table(rooms.table, rooms.imageColumn, frames);
  Halves halves;
  halves.rooms = table.column(rooms.roomColumn);
  const auto splits = table.column(rooms.splitColumn);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool wanted = rooms.rooms.empty() || std::find(rooms.rooms.begin(), rooms.rooms.end(),
                                                         halves.rooms[i]) != rooms.rooms.end();
    if (halves.rooms[i].empty() || !wanted) continue;
    if (splits[i] == rooms.train) halves.train.push_back(i);
    if (splits[i] == rooms.test) halves.test.push_back(i);
  }
  if (halves.train.empty() || halves.test.empty())
    throw Error(ErrorCode::insufficientData,
                fmt::format("{}: {} images to learn from and {} to ask; both halves need some",
                            rooms.table.string(), halves.train.size(), halves.test.size()));
  return halves;
}

/// Share of the queries whose nearest image shows the same kind of room.
double nearestNeighbor(const DescriptorSequence& labels, const std::vector<std::string>& rooms,
                       const std::vector<std::size_t>& train, const std::vector<std::size_t>& test) {
  const auto rows = [&](const std::vector<std::size_t>& chosen) {
    DescriptorMatrix matrix(labels.vocabulary.size());
    for (const std::size_t i : chosen) matrix.append(labels.descriptors.row(i));
    return matrix;
  };
  const Distance distance = getDistance(MapperOptions{}.distance, labels.vocabulary.layout().parts);
  const DescriptorMatrix known = rows(train);
  const DescriptorMatrix vectors = comparedVectors(known, known, distance);
  const DescriptorMatrix queries = comparedVectors(rows(test), known, distance);
  std::size_t right = 0;
  for (std::size_t q = 0; q < test.size(); ++q) {
    std::size_t best = 0;
    double least = compare(distance.comparison, vectors.row(0), queries.row(q));
    for (std::size_t i = 1; i < train.size(); ++i)
      if (const double d = compare(distance.comparison, vectors.row(i), queries.row(q)); d < least) {
        best = i;
        least = d;
      }
    right += rooms[train[best]] == rooms[test[q]] ? 1 : 0;
  }
  return static_cast<double>(right) / static_cast<double>(test.size());
}

CellResults rooms(const Task& task, const Recorder& recorder) {
  const auto images = openImages(task.rooms->images);
  const DescriptorSequence labels = recorder(*images);
  const Halves halves = readHalves(*task.rooms, labels.frames);
  return {{"nearest_neighbor", "", nearestNeighbor(labels, halves.rooms, halves.train, halves.test)},
          {"halves_exchanged", "", nearestNeighbor(labels, halves.rooms, halves.test, halves.train)}};
}

std::vector<Task> openTasks(const PlaceTasksOptions& options, std::vector<std::string>& notes) {
  std::vector<Task> tasks;
  const auto isThere = [&](const fs::path& path, bool optional) {
    if (!optional || fs::exists(path)) return true;
    notes.push_back(fmt::format("{} is not there and was left out", path.string()));
    return false;
  };
  for (const auto& drive : options.drives)
    if (isThere(drive.images.path, drive.optional))
      tasks.push_back({drive.name,
                       digestOf(drive.images) + digestOf(drive.again) +
                           (drive.truth.empty() ? "" : sha256OfFile(drive.truth)) +
                           (drive.imagesAlone ? "images alone" : ""),
                       &drive, nullptr});
  for (const auto& rooms : options.rooms)
    if (isThere(rooms.images.path, rooms.optional))
      tasks.push_back(
          {rooms.name,
           digestOf(rooms.images) + sha256OfFile(rooms.table) +
               fmt::format("{} {} {} {} {} {}", rooms.imageColumn, rooms.roomColumn, rooms.splitColumn,
                           rooms.train, rooms.test, fmt::join(rooms.rooms, ",")),
           nullptr, &rooms});
  if (tasks.empty())
    throw Error(ErrorCode::insufficientData,
                "none of the sequences is there; name one of yours by [[drive]] or [[rooms]]");
  return tasks;
}

Findings findingsOf(const std::vector<Task>& tasks, const std::vector<std::string>& models,
                    const std::vector<std::vector<CellResults>>& cells) {
  Findings findings;
  findings.title = "Places mapped, found again, and rooms told apart";
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    ResultTable table;
    table.title = tasks[t].name;
    table.caption =
        tasks[t].drive != nullptr
            ? "The map by its V-measure against the rooms; another drive found in it: the share of right "
              "answers by each image alone, by all images so far, and with twenty more."
            : "Share of images whose nearest one of the other half shows the same kind of room.";
    table.rowsAre = "model";
    std::vector<std::pair<std::string, CellResults>> rows;
    for (std::size_t m = 0; m < models.size(); ++m) rows.emplace_back(models[m], cells[t][m]);
    std::vector<Measure<CellResults>> found;
    for (const auto& [name, column] : measures)
      if (std::ranges::any_of(
              cells[t], [&, name = name](const auto& results) { return valueOf(results, name).has_value(); }))
        found.push_back(
            {column, [name = name](const CellResults& results) { return valueOf(results, name); }});
    findings.sections.emplace_back(pivot(std::move(table), rows, found));
  }
  findings.summary = fmt::format(
      "{} models on {} tasks, all with the default distance and thresholds that the "
      "runs found themselves.",
      models.size(), tasks.size());
  return findings;
}

OptionGroup declare(PlaceTasksOptions::Drive& drive) {
  OptionGroup group("drive", "A drive to map, and one to find in it.");
  group.add("name", &drive.name, "What to call it");
  group.add("optional", &drive.optional, "Leave out, with a note, when it is not there");
  group.add("images-alone", &drive.imagesAlone, "Leave out poses");
  return group;
}

OptionGroup declare(PlaceTasksOptions::Rooms& rooms) {
  OptionGroup group("rooms", "Rooms to tell apart.");
  group.add("name", &rooms.name, "What to call them");
  group.add("image-column", &rooms.imageColumn, "Column of the images' names");
  group.add("room-column", &rooms.roomColumn, "Column of the rooms");
  group.add("split-column", &rooms.splitColumn, "Column of the splits");
  group.add("train", &rooms.train, "Split that is learned from");
  group.add("test", &rooms.test, "Split that is asked about");
  group.add("optional", &rooms.optional, "Leave out, with a note, when they are not there");
  return group;
}

}  // namespace

PlaceTasksOptions readPlaceTasks(ConfigFile& config) {
  PlaceTasksOptions options;
  const toml::array *drives = nullptr, *rooms = nullptr;
  const auto texts = [&](std::vector<std::string>& to) {
    return [&config, &to](auto& n) {
      for (const auto& element : config.list(n)) to.push_back(config.text(element));
    };
  };
  config.read({{"type", true, "the kind of experiment", [](auto&) {}},
               {"models", false, "the models to compare", texts(options.models)},
               {"drive", false, "drives to map and find", [&](auto& n) { drives = &config.list(n); }},
               {"rooms", false, "rooms to tell apart", [&](auto& n) { rooms = &config.list(n); }}});
  if (drives != nullptr)
    for (const toml::node& node : *drives) {
      auto& drive = options.drives.emplace_back();
      const toml::table* again = nullptr;
      auto keys =
          together(sourceKeys(config, drive.images, true), requiring("name", keysOf(config, declare(drive))));
      keys.push_back({"truth", false, "CSV query,refs", [&](auto& n) { drive.truth = config.anywhere(n); }});
      keys.push_back({"again", true, "the drive to find", [&](auto& n) { again = &config.subtable(n); }});
      config.read(config.subtable(node), keys);
      drive.again = drive.images;  // equal except for the labels
      config.read(*again, sourceKeys(config, drive.again, false));
    }
  if (rooms != nullptr)
    for (const toml::node& node : *rooms) {
      auto& set = options.rooms.emplace_back();
      auto keys =
          together(sourceKeys(config, set.images, true), requiring("name", keysOf(config, declare(set))));
      keys.push_back({"table", true, "the CSV of rooms", [&](auto& n) { set.table = config.anywhere(n); }});
      keys.push_back({"only", false, "only these rooms", texts(set.rooms)});
      config.read(config.subtable(node), keys);
    }
  return options;
}

GridColumns placeTasksColumns() {
  GridColumns columns{{"model", "task"}, "", {}};
  for (const auto& measure : measures) columns.measures.push_back(measure.first);
  return columns;
}

Findings comparePlaceTasks(const PlaceTasksOptions& options, Grid& grid, const ExperimentRun& run,
                           Progress& progress) {
  std::vector<std::string> notes;
  const auto models = modelsToCompare(options.models, run, notes);
  const auto tasks = openTasks(options, notes);
  std::vector<std::string> names;
  std::vector<std::vector<CellResults>> cells(tasks.size());
  std::vector<std::pair<std::string, std::string>> identities;
  for (const Candidate& model : models) {
    names.push_back(model.name);
    const auto labeler = loadModel(model.model, run.labeler);
    identities.emplace_back("Model", labeler->identity());
    const Recorder recorder = [&](const Sequence& sequence) {
      return labelAll(sequence, *labeler, fmt::format("{}: labeling {}", model.name, sequence.name()),
                      {.cache = run.cache}, progress);
    };
    std::vector<Cell> grids;
    for (const Task& task : tasks)
      grids.push_back({{model.name, task.name},
                       sha256(fmt::format("{} {} {}", placeTasksVersion, labeler->cacheKey(), task.inputs))});
    const auto found = grid.run(
        grids,
        [&](std::size_t t) {
          return tasks[t].drive != nullptr ? drive(tasks[t], recorder, run.folder / ".map.estancia")
                                           : rooms(tasks[t], recorder);
        },
        progress, model.name);
    for (std::size_t t = 0; t < tasks.size(); ++t) cells[t].push_back(found[t]);
  }
  Findings findings = findingsOf(tasks, names, cells);
  findings.facts = std::move(identities);
  findings.notes = std::move(notes);
  return findings;
}

}  // namespace estancia::experiments
