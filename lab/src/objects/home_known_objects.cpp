// SPDX-License-Identifier: Apache-2.0
#include "objects/home_known_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/layers/known_objects.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_map.hpp"
#include "findings/pivot.hpp"
#include "recognition/made_up_models.hpp"
#include "runner/config_lists.hpp"
#include "runner/scratch_file.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace fs = std::filesystem;
namespace {

constexpr int homeKnownObjectsVersion = 1;  // version of the code below: cells of another one are found anew
const std::string smallRow = "small", largeRow = "large", absentRow = "not in the home";

/// A drive with its truth.
struct KnownDrive {
  explicit KnownDrive(const fs::path& where)
      : folder(where), sequence(openSequence(where, {})), truth(io::readHomeTruth(where)) {
    if (!sequence->hasDepth() || !sequence->intrinsics() || truth.instances.empty())
      throw Error(ErrorCode::invalidInput,
                  fmt::format("{} has no depth, no camera or no instances.csv; known objects need all",
                              folder.string()));
  }
  const io::HomeInstance* find(int id) const {
    const auto at = std::ranges::find(truth.instances, id, &io::HomeInstance::id);
    return at == truth.instances.end() ? nullptr : &*at;
  }
  /// Whether enough frames show enough of a thing.
  bool shows(int id, std::size_t pixels) const {
    constexpr std::ptrdiff_t frames = 4;
    return std::ranges::count_if(truth.visible, [&](const auto& image) {
             return std::ranges::any_of(image.second, [&](const io::VisibleInstance& seen) {
               return seen.id == id && static_cast<std::size_t>(seen.pixelsWithDepth) >= pixels;
             });
           }) >= frames;
  }

  fs::path folder;
  std::unique_ptr<Sequence> sequence;
  io::HomeTruth truth;
};

double diagonalOf(const io::HomeInstance& thing) {
  return cv::norm(thing.size);
}

std::string sizeOf(const io::HomeInstance& thing) {
  return diagonalOf(thing) <= 0.75 ? smallRow : largeRow;
}

/// Things that both drives show, no planes, in an order that has nothing to do with what they are.
std::vector<io::HomeInstance> chosenThings(const KnownDrive& from, const KnownDrive& to,
                                           const HomeKnownObjectsOptions& options) {
  std::vector<io::HomeInstance> all = from.truth.instances;
  std::ranges::sort(all, {}, [](const io::HomeInstance& t) { return std::pair(t.id * 7919 % 1009, t.id); });
  std::map<std::string, std::size_t> taken;
  std::vector<io::HomeInstance> chosen;
  for (const io::HomeInstance& thing : all) {
    const double thin = std::min({thing.size.x, thing.size.y, thing.size.z}), diagonal = diagonalOf(thing);
    if (thin < 0.05 * diagonal || diagonal > 2.4 || taken[sizeOf(thing)] >= options.models) continue;
    const std::size_t pixels = options.minPixels * (sizeOf(thing) == smallRow ? 2 : 5) / 2;
    if (to.find(thing.id) == nullptr || !from.shows(thing.id, pixels) || !to.shows(thing.id, pixels))
      continue;
    ++taken[sizeOf(thing)];
    chosen.push_back(thing);
  }
  return chosen;
}

/// What all frames show of things: clouds in their own frames, one point a cell of a 200th of the diagonal.
std::map<int, PointCloud> cutOut(const KnownDrive& drive, const std::vector<io::HomeInstance>& things,
                                 std::size_t every) {
  struct Cut {
    cv::Affine3d toThing;
    double cell;
    std::set<std::array<int, 3>> taken;
    PointCloud cloud;
  };
  std::map<int, Cut> cuts;
  for (const io::HomeInstance& thing : things)
    cuts[thing.id] = {
        cv::Affine3d(cv::Vec3d(0, 0, thing.yaw), cv::Vec3d(thing.center.x, thing.center.y, thing.center.z))
            .inv(),
        std::max(0.003, diagonalOf(thing) / 200),
        {},
        {}};
  for (std::size_t i = 0; i < drive.sequence->size(); i += every) {
    const Frame frame = drive.sequence->frame(i);
    if (!frame.pose) continue;
    const cv::Mat mask = io::readInstanceMask(io::instanceMaskFile(drive.folder, frame));
    const PointCloud seen = backProject(drive.sequence->depth(i), *drive.sequence->intrinsics());
    if (mask.total() != seen.points.size())
      throw Error(ErrorCode::mismatch,
                  fmt::format("{}: masks and depth differ in size", drive.folder.string()));
    for (std::size_t p = 0; p < mask.total(); ++p) {
      const auto cut = cuts.find(mask.ptr<std::uint16_t>()[p]);
      if (cut == cuts.end() || !isFinite(seen.points[p])) continue;
      Cut& of = cut->second;
      const cv::Point3d at = of.toThing * (rigidOf(*frame.pose) * cv::Point3d(seen.points[p]));
      const auto number = [&](double x) { return static_cast<int>(std::floor(x / of.cell)); };
      if (of.taken.insert({number(at.x), number(at.y), number(at.z)}).second)
        of.cloud.points.emplace_back(at);
    }
  }
  std::map<int, PointCloud> clouds;
  for (auto& [id, cut] : cuts) {
    cut.cloud.width = cut.cloud.points.size();
    cut.cloud.height = 1;
    clouds[id] = std::move(cut.cloud);
  }
  return clouds;
}

/// One model of each family but plates, which no segment of a home is.
std::map<std::string, PointCloud> notInTheHome() {
  std::map<std::string, PointCloud> models;
  for (const MadeUpModel& model : madeUpModels(1))
    if (model.family != "plate") models.emplace(model.family, model.whole);
  return models;
}

/// The map of a drive in which they were looked for. Words do not count.
WorldMap mapWith(const KnownDrive& drive, const fs::path& file,
                 const std::shared_ptr<const KnownObjects>& known, std::size_t every) {
  const Vocabulary vocabulary({"one", "other"});
  const LexicalDescriptor words{0.5F, 0.5F};
  auto session = MappingSession::create(file, vocabulary, "none", {}, ExistingMap::replace);
  WorldMapper world(session);
  for (std::size_t i = 0; i < drive.sequence->size(); i += every) {
    if (interrupted()) throw Interrupted("");
    Frame frame = drive.sequence->frame(i);
    frame.pose = world.observe(frame, words, drive.sequence->image(i), drive.sequence->depth(i),
                               *drive.sequence->intrinsics());
    session.add(frame, words);
  }
  world.recognize(known);
  session.finish();
  world.finish();
  return readWorld(file);
}

bool isThing(const WorldObject& object, const io::HomeInstance& thing) {
  const double diagonal = diagonalOf(thing);
  const cv::Point3d at(object.known->pose.x, object.known->pose.y, object.known->pose.z);
  return cv::norm(object.center - thing.center) < std::max(0.12, diagonal / 4) ||
         cv::norm(at - thing.center) < std::max(0.1, 0.15 * diagonal);
}

CellResults judge(const WorldMap& world, const KnownDrive& drive,
                  const std::map<std::string, io::HomeInstance>& things, std::size_t absent) {
  std::map<std::string, double> models, wrong;
  std::map<std::string, std::set<std::string>> right;
  for (const auto& [name, thing] : things) ++models[sizeOf(thing)];
  models[absentRow] = static_cast<double>(absent);
  for (const WorldObject& object : world.objects) {
    if (!object.known) continue;
    const auto model = things.find(object.known->name);
    if (model == things.end()) {
      ++wrong[absentRow];
      continue;
    }
    const io::HomeInstance& cut = model->second;
    const bool is = std::ranges::any_of(drive.truth.instances, [&](const io::HomeInstance& thing) {
      return (thing.id == cut.id ||
              (thing.model == cut.model && thing.modelName == cut.modelName && thing.size == cut.size)) &&
             isThing(object, thing);
    });
    if (is)
      right[sizeOf(cut)].insert(model->first);
    else
      ++wrong[sizeOf(cut)];
  }
  CellResults results;
  for (const auto& [size, count] : models) {
    results.push_back({"models", size, count});
    results.push_back({"right", size, static_cast<double>(right[size].size())});
    results.push_back({"wrong", size, wrong[size]});
  }
  return results;
}

CellResults lookFor(const fs::path& to, const fs::path& from, const HomeKnownObjectsOptions& options,
                    const fs::path& folder) {
  const KnownDrive map(to), source(from);
  const std::vector<io::HomeInstance> chosen = chosenThings(source, map, options);
  std::map<std::string, io::HomeInstance> things;
  std::vector<std::unique_ptr<ScratchFile>> files;
  std::vector<ModelFile> models;
  const auto add = [&](const std::string& name, const PointCloud& cloud) {
    files.push_back(
        std::make_unique<ScratchFile>(folder / fmt::format(".{}.{}.ply", to.filename().string(), name)));
    writeCloud(cloud, files.back()->path());
    models.push_back({name, files.back()->path()});
  };
  const std::map<int, PointCloud> clouds = cutOut(source, chosen, options.every);
  for (const io::HomeInstance& thing : chosen) {
    const std::string name = fmt::format("{}-{}", thing.category, thing.id);
    things.emplace(name, thing);
    add(name, clouds.at(thing.id));
  }
  const auto absent = notInTheHome();
  for (const auto& [name, cloud] : absent) add(name, cloud);
  const ScratchFile file(folder / fmt::format(".{}.estancia", to.filename().string()));
  const auto begin = std::chrono::steady_clock::now();
  const WorldMap world =
      mapWith(map, file.path(), std::make_shared<const KnownObjects>(models), options.every);
  CellResults results = judge(world, map, things, absent.size());
  results.push_back(
      {"seconds", "", std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()});
  return results;
}

struct SizeRow {
  double models = 0, right = 0, wrong = 0;
};

ResultTable knownTable(const std::string& title, const CellResults& results) {
  std::vector<std::pair<std::string, SizeRow>> rows;
  for (const std::string& size : {smallRow, largeRow, absentRow}) {
    const auto get = [&](const char* measure) { return valueOf(results, measure, size).value_or(0); };
    rows.push_back({size, {get("models"), get("right"), get("wrong")}});
  }
  return pivot<SizeRow>({title,
                         "Right: models whose thing has their name. Wrong: objects that have the name of "
                         "another thing. Small: a diagonal of at most 0.75 m.",
                         "size",
                         {},
                         {}},
                        rows,
                        {{{"models", 0}, [](auto& s) { return s.models; }},
                         {{"right", 0}, [](auto& s) { return s.right; }},
                         {{"wrong", 0}, [](auto& s) { return s.wrong; }}});
}

}  // namespace

HomeKnownObjectsOptions readHomeKnownObjects(ConfigFile& config) {
  HomeKnownObjectsOptions options;
  OptionGroup group("home-known-objects", "Things of one drive, looked for in another.");
  group.add("models", &options.models, "Models of small things, and as many of others").range(1, 1000);
  group.add("least-pixels", &options.minPixels, "Pixels of a small thing that four frames show").range(1);
  group.add("every", &options.every, "Takes every such frame").range(1);
  const auto drives = each(config, options.drives, [&](auto& n) { return config.anywhere(n).string(); });
  config.read(
      together(keysOf(config, std::move(group)), {{"type", true, "the kind of experiment", [](auto&) {}},
                                                  {"drives", true, "the folders of drives", drives}}));
  return options;
}

GridColumns homeKnownObjectsColumns() {
  return {{"map", "models_of"}, "size", {"models", "right", "wrong", "seconds"}};
}

Findings findHomeKnownObjects(const HomeKnownObjectsOptions& options, Grid& grid, const ExperimentRun& run,
                              Progress& progress) {
  refuseModels(run, "known objects");
  std::vector<Cell> cells;
  std::vector<std::pair<fs::path, fs::path>> pairs;
  for (const fs::path to : options.drives)
    for (const fs::path from : options.drives) {
      if (to == from) continue;
      pairs.emplace_back(to, from);
      cells.push_back({{to.filename().string(), from.filename().string()},
                       sha256(fmt::format("{} {} {} {} {} {} {} {}", homeKnownObjectsVersion, to.string(),
                                          sha256OfFile(to / "instances.csv"), from.string(),
                                          sha256OfFile(from / "instances.csv"), options.models,
                                          options.minPixels, options.every))});
    }
  const auto found = grid.run(
      cells, [&](std::size_t i) { return lookFor(pairs[i].first, pairs[i].second, options, run.folder); },
      progress, "looking for known objects");
  Findings findings;
  findings.title = "Known objects in maps of a home";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    double models = 0, right = 0, wrong = 0;
    for (const CellResult& result : found[i]) {
      models += result.measure == "models" && result.at != absentRow ? result.value : 0;
      right += result.measure == "right" ? result.value : 0;
      wrong += result.measure == "wrong" ? result.value : 0;
    }
    findings.summary += fmt::format(
        "{}{}, models of {}: {} of {} things have their name, {} objects that of another.", i == 0 ? "" : " ",
        cells[i].coordinates[0], cells[i].coordinates[1], right, models, wrong);
    findings.sections.emplace_back(knownTable(
        fmt::format("{}, models of {}", cells[i].coordinates[0], cells[i].coordinates[1]), found[i]));
  }
  return findings;
}

}  // namespace estancia::experiments
