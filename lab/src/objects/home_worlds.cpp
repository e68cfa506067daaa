// SPDX-License-Identifier: Apache-2.0
#include "objects/home_worlds.hpp"

#include <fmt/format.h>

#include <chrono>
#include <set>
#include <utility>

#include "estancia/areas/areas.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_query/evaluate_world.hpp"
#include "runner/config_lists.hpp"
#include "runner/scratch_file.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int homeWorldsVersion = 1;  // version of the code below: cells of another one are computed anew
const std::string givenPoses = "given poses", ownOdometry = "own odometry";

Choices waysToPoses() {
  return {{givenPoses, "the true poses of the drive"}, {ownOdometry, "tracked from depth in the same pass"}};
}

/// Maps a drive whose frames are labeled. Returns the seconds that it took.
double mapWorld(LabeledDrives& labeled, const LabeledDrive& drive, bool withPoses, const fs::path& file) {
  const DescriptorSequence& recording = drive.recording;
  std::vector<std::string> names;
  for (const Frame& frame : recording.frames) names.push_back(frame.name);
  const std::vector<std::size_t> numbers = io::framesOfImages(*drive.images, drive.images->name(), names);
  const auto begin = std::chrono::steady_clock::now();
  auto session =
      MappingSession::create(file, recording.vocabulary, recording.model, {}, ExistingMap::replace);
  WorldMapper world(session, &labeled.labeler(),
                    withPoses ? std::nullopt : std::optional(*drive.images->intrinsics()));
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    if (interrupted()) throw Interrupted("");
    Frame frame = recording.frames[i];
    if (!withPoses) frame.pose.reset();
    const DescriptorView words = recording.descriptors.row(i);
    frame.pose = world.observe(frame, words, drive.images->image(numbers[i]), drive.images->depth(numbers[i]),
                               *drive.images->intrinsics());
    session.add(frame, words);
  }
  session.finish();
  world.finish();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void addIfKnown(CellResults& results, const char* measure, const std::optional<double>& value) {
  if (value) results.push_back({measure, "", *value});
}

CellResults resultsOf(const WorldAccuracy& accuracy) {
  CellResults results{{"areas", "", static_cast<double>(accuracy.areas)}};
  if (accuracy.areasAndRooms) results.push_back({"v_measure", "", accuracy.areasAndRooms->vMeasure});
  if (accuracy.areasAndRoomsSeen)
    results.push_back({"seen_v_measure", "", accuracy.areasAndRoomsSeen->vMeasure});
  if (accuracy.trajectory) results.push_back({"rmse", "", accuracy.trajectory->rmse});
  if (!accuracy.objects) return results;
  const InstanceAccuracy& objects = *accuracy.objects;
  const InstanceScore& all = objects.counted;
  results.push_back({"things", "", static_cast<double>(all.things)});
  results.push_back({"objects", "", static_cast<double>(all.instances)});
  addIfKnown(results, "recall", all.recall());
  addIfKnown(results, "precision", all.precision());
  addIfKnown(results, "error", all.error);
  addIfKnown(results, "split", objects.split);
  addIfKnown(results, "merged", objects.merged);
  results.push_back({"nameable", "", static_cast<double>(all.nameable)});
  addIfKnown(results, "named", all.nameAccuracy());
  return results;
}

CellResults mapHome(LabeledDrives& labeled, const NamedDrive& drive, bool withPoses,
                    const ThingClasses& classes) {
  const LabeledDrive& known = labeled.of(drive.images);
  if (!known.images->hasDepth() || !known.images->intrinsics())
    throw Error(
        ErrorCode::insufficientData,
        fmt::format("{} has no depth or no camera; areas and objects need both", drive.images.path.string()));
  const ScratchFile file(labeled.run().folder / ".world.estancia");
  const double seconds = mapWorld(labeled, known, withPoses, file.path());
  std::vector<std::string> images;
  for (const Frame& frame : known.recording.frames) images.push_back(frame.name);
  const fs::path& folder = drive.images.path;
  CellResults results = resultsOf(evaluateWorld(file.path(), folder, io::roomsSeen(folder, images), classes));
  const auto frames = static_cast<double>(images.size());
  results.push_back({"frames", "", frames});
  results.push_back({"frames_per_second", "", frames / seconds});
  return results;
}

/// What the results depend on beside the images.
std::string digestOfThings(const fs::path& folder) {
  std::string digests;
  for (const char* file : {"home.json", "instances.csv", "visible.csv"})
    if (fs::exists(folder / file)) digests += sha256OfFile(folder / file);
  return digests;
}

Findings worldFindings(const DriveResults& results) {
  constexpr auto largest = ResultTable::Best::largest, smallest = ResultTable::Best::smallest;
  const auto measures = measuresIn(results.cells, {{"frames", {"frames", 0}},
                                                   {"areas", {"areas", 0}},
                                                   {"v_measure", {"areas: V-measure", 3, largest}},
                                                   {"seen_v_measure", {"seen: V-measure", 3, largest}},
                                                   {"rmse", {"RMSE [m]", 3, smallest}},
                                                   {"things", {"things", 0}},
                                                   {"objects", {"objects", 0}},
                                                   {"recall", {"recall", 3, largest}},
                                                   {"precision", {"precision", 3, largest}},
                                                   {"error", {"error [m]", 3, smallest}},
                                                   {"split", {"split", 0}},
                                                   {"merged", {"merged", 0}},
                                                   {"nameable", {"nameable", 0}},
                                                   {"named", {"right names", 3, largest}},
                                                   {"frames_per_second", {"frames/s", 1}}});
  Findings findings;
  findings.title = "Whole maps beside the truth";
  results.each([&](std::size_t model, std::size_t drive) {
    std::vector<std::pair<std::string, CellResults>> rows;
    for (std::size_t v = 0; v < results.variants.size(); ++v)
      rows.emplace_back(results.variants[v], results.of(model, drive, v));
    findings.sections.emplace_back(pivot(
        ResultTable{results.titleOf(model, drive),
                    "Areas: against the rooms stood in and the rooms seen. RMSE: of the positions after "
                    "alignment. Recall and precision: objects are things where their boxes have an "
                    "intersection over union of 0.25 or more; without fixtures and what hangs at walls. "
                    "Error: median, between the middles of the boxes. Names: of the found things that the "
                    "model's labels can name. Frames/s: with the images of objects labeled, and the words "
                    "of the frames known.",
                    "poses",
                    {},
                    {}},
        rows, measures));
  });
  findings.summary = fmt::format("{} drives, mapped in {} ways with the defaults.", results.drives.size(),
                                 results.variants.size());
  return findings;
}

}  // namespace

HomeWorldsOptions readHomeWorlds(ConfigFile& config) {
  HomeWorldsOptions options;
  const toml::array* drives = nullptr;
  config.read(
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"models", false, "the models that label",
        each(config, options.models, [&config](const toml::node& n) { return config.text(n); })},
       {"poses", false, "where poses come from", each(config, options.poses, oneOf(config, waysToPoses()))},
       {"things", true, "the file of the classes and names of things",
        [&](auto& n) { options.things = config.anywhere(n); }},
       {"drive", true, "[[drive]] names a drive through a home",
        [&](auto& n) { drives = &config.list(n); }}});
  for (const toml::node& node : *drives)
    options.drives.push_back(readNamedDrive(config, config.subtable(node)));
  if (options.poses.empty())
    for (const auto& way : waysToPoses()) options.poses.push_back(way.name);
  return options;
}

GridColumns homeWorldsColumns() {
  return {{"model", "drive", "poses"},
          "",
          {"frames", "areas", "v_measure", "seen_v_measure", "rmse", "things", "objects", "recall",
           "precision", "error", "split", "merged", "nameable", "named", "frames_per_second"}};
}

Findings mapHomeWorlds(const HomeWorldsOptions& options, Grid& grid, const ExperimentRun& run,
                       Progress& progress) {
  const ThingClasses classes = readThingClasses(options.things);
  const std::string digest = sha256OfFile(options.things);
  const auto inputs = [&](const NamedDrive& drive, std::size_t) {
    return fmt::format("{} {} {}", homeWorldsVersion, digest, digestOfThings(drive.images.path));
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t way) {
    return mapHome(labeled, drive, options.poses[way] == givenPoses, classes);
  };
  return studyDrives({options.models, options.drives, options.poses, inputs, compute}, worldFindings, grid,
                     run, progress);
}

}  // namespace estancia::experiments
