// SPDX-License-Identifier: Apache-2.0
#include "places/further_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/joining/merge_maps.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/session/session.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_map.hpp"
#include "places/revisits.hpp"
#include "runner/scratch_file.hpp"

namespace estancia::experiments {
namespace {

constexpr int furtherDrivesVersion = 1;  // version of the code below: cells of another one are computed anew

struct Way {
  const char* name;
  bool isMerged, hasPoses, hasDepth;
};
constexpr std::array<Way, 6> ways{{{"continued, with poses", false, true, false},
                                   {"continued, words alone", false, false, false},
                                   {"continued, with depth", false, true, true},
                                   {"merged, with poses", true, true, false},
                                   {"merged, words alone", true, false, false},
                                   {"merged, with depth", true, true, true}}};

/// Frame of the second drive's poses.
const cv::Affine3d otherFrame(cv::Vec3d(0, 0, 2.1), cv::Vec3d(7, -3, 0));

/// A labeled drive as one way to map it sees it.
struct View {
  const LabeledDrive& drive;
  std::size_t skipped;
  /// T_true_own of its poses; nothing: it has none.
  std::optional<cv::Affine3d> frame;
  bool hasDepth;

  std::size_t size() const { return drive.recording.frames.size() - skipped; }
  Frame known(std::size_t i) const {
    Frame seen = drive.recording.frames[skipped + i];
    seen.pose = seen.pose && frame ? std::optional(poseOf(frame->inv() * rigidOf(*seen.pose))) : std::nullopt;
    return seen;
  }
};

/// Goes on with the map where there is one.
void mapInto(const std::filesystem::path& file, const View& view, LabeledDrives& labeled) {
  const DescriptorSequence& recording = view.drive.recording;
  const bool isFirst = !std::filesystem::exists(file);
  auto session = isFirst ? MappingSession::create(file, recording.vocabulary, recording.model, {})
                         : MappingSession::resume(file, recording.vocabulary, recording.model);
  std::vector<std::string> names;
  for (const Frame& frame : recording.frames) names.push_back(frame.name);
  std::optional<WorldMapper> world;
  if (view.hasDepth) world.emplace(session, &labeled.labeler());
  session.beginDrive({.name = view.drive.images->name()});
  if (world) world->beginDrive();
  const std::vector<std::size_t> numbers =
      io::framesOfImages(*view.drive.images, view.drive.images->name(), names);
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (interrupted()) throw Interrupted("");
    const std::size_t number = numbers[view.skipped + i];
    const DescriptorView words = recording.descriptors.row(view.skipped + i);
    const Frame frame = view.known(i);
    if (world)
      world->observe(frame, words, view.drive.images->image(number), view.drive.images->depth(number),
                     *view.drive.images->intrinsics());
    session.add(frame, words);
  }
  session.finish();
  if (world) world->finish();
}

CellResults resultsOf(const FurtherDrive& found) {
  const auto count = [](std::size_t number) { return static_cast<double>(number); };
  CellResults results{{"frames", "", count(found.frames)}, {"near", "", count(found.near)},
                      {"known", "", count(found.known)},   {"right", "", count(found.right)},
                      {"wrong", "", count(found.wrong)},   {"grown", "", count(found.grown)},
                      {"joined", "", count(found.joined)}};
  if (found.firstRight) results.push_back({"first_right", "", count(*found.firstRight)});
  if (found.poseError) results.push_back({"pose_error", "", *found.poseError});
  return results;
}

CellResults mapTwice(const FurtherDrivesOptions::Pair& pair, const Way& way, LabeledDrives& labeled) {
  const LabeledDrive &one = labeled.of(pair.itself.images), &other = labeled.of(pair.then);
  const auto hasDepth = [](const LabeledDrive& drive) {
    return drive.images->hasDepth() && drive.images->intrinsics().has_value();
  };
  if (way.hasDepth && !(hasDepth(one) && hasDepth(other))) return {};
  if (pair.skipped >= other.recording.frames.size())
    throw Error(ErrorCode::invalidOption,
                fmt::format("{}: all images of the second drive are skipped", pair.itself.name));
  const auto frameOf = [&way](const cv::Affine3d& frame) {
    return way.hasPoses ? std::optional(frame) : std::nullopt;
  };
  const View first{one, 0, frameOf(cv::Affine3d::Identity()), way.hasDepth};
  const View second{other, pair.skipped, frameOf(otherFrame), way.hasDepth};
  const ScratchFile map(labeled.run().folder / ".map.estancia"),
      more(labeled.run().folder / ".more.estancia");
  for (const ScratchFile* left : {&map, &more}) std::filesystem::remove(left->path());  // by an ended run
  mapInto(map.path(), first, labeled);
  mapInto(way.isMerged ? more.path() : map.path(), second, labeled);
  if (way.isMerged)
    mergeMaps(std::vector<std::filesystem::path>{map.path(), more.path()}, map.path(), ExistingMap::replace);
  std::vector<Frame> truth = one.recording.frames;
  truth.insert(truth.end(), other.recording.frames.begin() + static_cast<std::ptrdiff_t>(pair.skipped),
               other.recording.frames.end());
  const WorldMap world = readWorld(map.path());
  CellResults results = resultsOf(furtherDriveIn(truth, world.places, pair.isElsewhere));
  if (!way.hasDepth || pair.isElsewhere) return results;
  std::vector<std::string> rooms;
  for (const Frame& frame : truth) rooms.push_back(frame.room);
  if (const auto agreement = measureNamedAgreement(rooms, world.areaOfFrame).agreement)
    results.push_back({"v_measure", "", agreement->vMeasure});
  return results;
}

FurtherDrivesOptions::Pair readPair(ConfigFile& config, const toml::table& table) {
  FurtherDrivesOptions::Pair pair;
  const toml::table* then = nullptr;
  pair.itself = readNamedDrive(
      config, table,
      {{"then", true, "the drive that follows", [&](auto& n) { then = &config.subtable(n); }},
       {"skip", false, "images that are left out at the begin of the drive that follows",
        [&](auto& n) { pair.skipped = static_cast<std::size_t>(config.integer(n, 0, 1'000'000)); }},
       {"elsewhere", false, "whether that drive was in another building",
        [&](auto& n) { pair.isElsewhere = config.flag(n); }}});
  pair.then = pair.itself.images;  // equal except for the labels
  config.read(*then, sourceKeys(config, pair.then, true));
  return pair;
}

}  // namespace

FurtherDrive furtherDriveIn(const std::vector<Frame>& truth, const TopologicalMap& map, bool isElsewhere) {
  if (map.frames.size() != truth.size() || map.drives.size() != 2)
    throw Error(ErrorCode::mismatch, fmt::format("{} of {} frames were mapped, in {} drives",
                                                 map.frames.size(), truth.size(), map.drives.size()));
  for (const Frame& frame : truth)
    if (!frame.pose)
      throw Error(ErrorCode::insufficientData,
                  fmt::format("{}: no true pose to compare with; give one by `poses`", frame.name));
  const std::size_t begin = map.drives[1].firstFrame;
  std::map<int, std::vector<std::size_t>> before;
  for (std::size_t i = 0; i < begin; ++i) before[map.frames[i].node].push_back(i);
  FurtherDrive found;
  double error = 0;
  std::size_t posed = 0;
  bool cameSo = false;  // into this place
  for (std::size_t i = begin; i < truth.size(); ++i) {
    const Frame& frame = truth[i];
    ++found.frames;
    if (const auto& pose = map.frames[i].pose) {
      error += distanceBetween(*pose, *frame.pose);
      ++posed;
    }
    for (std::size_t j = 0; j < begin && !isElsewhere; ++j)
      if (isNear(truth[j], frame, 0.7, 30)) {
        ++found.near;
        break;
      }
    const auto place = before.find(map.frames[i].node);
    if (place == before.end()) continue;
    ++found.known;
    const auto isThere = [&](std::size_t j) { return distanceBetween(*truth[j].pose, *frame.pose) <= 1; };
    const auto isSameRoom = [&](std::size_t j) { return !frame.room.empty() && truth[j].room == frame.room; };
    if (!isElsewhere && std::ranges::any_of(place->second, isThere)) {
      ++found.right;
      if (!found.firstRight) found.firstRight = i - begin;
    }
    const bool isOutside = isElsewhere || (std::ranges::none_of(place->second, isThere) &&
                                           std::ranges::none_of(place->second, isSameRoom));
    if (i == begin || map.frames[i].node != map.frames[i - 1].node) cameSo = isOutside;
    if (isOutside) ++(cameSo ? found.wrong : found.grown);
  }
  if (posed > 0 && !isElsewhere) found.poseError = error / static_cast<double>(posed);
  for (const Merge& merge : map.merges) found.joined += merge.frame + 1 == truth.size() ? 1 : 0;
  return found;
}

FurtherDrivesOptions readFurtherDrives(ConfigFile& config) {
  FurtherDrivesOptions options;
  readDrives(config, options.models, "images with poses",
             [&](const toml::table& table) { options.pairs.push_back(readPair(config, table)); });
  return options;
}

GridColumns furtherDrivesColumns() {
  return {{"model", "drive", "variant"},
          "",
          {"frames", "near", "known", "right", "wrong", "grown", "first_right", "joined", "pose_error",
           "v_measure"}};
}

Findings compareFurtherDrives(const FurtherDrivesOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress) {
  std::vector<NamedDrive> drives;
  for (const auto& pair : options.pairs) drives.push_back(pair.itself);
  std::vector<std::string> variants;
  for (const Way& way : ways) variants.emplace_back(way.name);
  const auto pairOf = [&](const NamedDrive& named) -> const FurtherDrivesOptions::Pair& {
    return *std::ranges::find(options.pairs, named.name, [](const auto& p) { return p.itself.name; });
  };
  const auto inputs = [&](const NamedDrive& named, std::size_t) {
    const FurtherDrivesOptions::Pair& pair = pairOf(named);
    return fmt::format("{} {} {} {}", furtherDrivesVersion, pair.skipped, pair.isElsewhere,
                       digestOf(pair.then));
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& named, std::size_t way) {
    return mapTwice(pairOf(named), ways[way], labeled);
  };
  return studyDrives({options.models, drives, variants, inputs, compute}, furtherDrivesFindings, grid, run,
                     progress);
}

Findings furtherDrivesFindings(const DriveResults& results) {
  constexpr auto largest = ResultTable::Best::largest, smallest = ResultTable::Best::smallest;
  const auto measures = measuresIn(results.cells, {{"frames", {"frames", 0}},
                                                   {"near", {"near", 0}},
                                                   {"known", {"known", 0}},
                                                   {"right", {"right", 0, largest}},
                                                   {"wrong", {"wrong", 0, smallest}},
                                                   {"grown", {"grown", 0}},
                                                   {"first_right", {"first right", 0, smallest}},
                                                   {"joined", {"places joined", 0}},
                                                   {"pose_error", {"pose error [m]", 4, smallest}},
                                                   {"v_measure", {"areas: V-measure", 3, largest}}});
  Findings findings;
  findings.title = "Drives that follow another one";
  results.each([&](std::size_t model, std::size_t drive) {
    std::vector<std::pair<std::string, CellResults>> rows;
    for (std::size_t v = 0; v < results.variants.size(); ++v)
      if (const CellResults& cell = results.of(model, drive, v); !cell.empty())
        rows.emplace_back(results.variants[v], cell);
    findings.sections.emplace_back(pivot(
        ResultTable{
            results.titleOf(model, drive),
            "Of the images of the second drive, near: within 0.7 m and 30° of one of the first; known: "
            "in a place of the first; right: that holds an image within a meter. Where a place holds none "
            "within a meter or of the same room, wrong: the robot was taken to be there; grown: it was "
            "there, and drove on, and the place grew. Pose error: mean, of the images whose pose is known in "
            "the map; the second drive's poses are in a frame of their own.",
            "way",
            {},
            {}},
        rows, measures));
  });
  findings.summary = fmt::format("{} pairs of drives in one map, continued and merged, with the defaults.",
                                 results.drives.size());
  return findings;
}

}  // namespace estancia::experiments
