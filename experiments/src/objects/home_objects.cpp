// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/objects/home_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/planar_pose.hpp"
#include "estancia/io/home_truth.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/objects/instance_accuracy.hpp"
#include "estancia/objects/instance_map.hpp"
#include "estancia/world/observation.hpp"
#include "experiments/src/findings/pivot.hpp"
#include "experiments/src/runner/subjects.hpp"

namespace estancia::experiments {
namespace {

constexpr int homeObjectsVersion = 1;  // of what follows: drives of another one are mapped anew
constexpr int leastFrames = 5;
const std::string kApart = "fixture", kCounted = "all but fixture";

/// Pixels of each thing that a segment shows, by the thing's id; below io::kFirstInstance structure.
using Shown = std::map<int, double>;

struct HomeMap {
  std::vector<ObjectInstance> instances;
  std::map<SegmentPlace, Shown> shown;
};

HomeMap mapHome(const std::filesystem::path& folder, double noise, const HomeSegmentationOptions& options) {
  const auto opened = openSequence(folder, {});
  const Sequence& sequence = *opened;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (sequence.frame(i).pose) poses.push_back(*sequence.frame(i).pose);
  if (!sequence.hasDepth() || !sequence.intrinsics() || poses.empty())
    throw Error(ErrorCode::invalidInput,
                fmt::format("{} has no depth, no camera or no poses; objects need all", folder.string()));
  HomeMap home;
  InstanceMap map{Floor(poses)};
  ClusterOptions clustering;
  clustering.threads = 1;  // drives are taken side by side
  for (std::size_t i = 0; i < sequence.size(); i += options.every) {
    if (!sequence.frame(i).pose) continue;
    cv::Mat depth = sequence.depth(i);
    cv::RNG random(options.seed + i);
    for (float& z : cv::Mat_<float>(depth))
      z += z > 0 ? static_cast<float>(random.gaussian(noise) * z * z) : 0;
    Observation seen = observe(depth, *sequence.intrinsics());
    findSegments(seen, {}, clustering);
    map.add(i, depthOf(seen), seen.segments, seen.camera, *sequence.frame(i).pose);
    const cv::Mat mask = io::readInstanceMask(io::instanceMaskFile(folder, sequence.frame(i)));
    if (mask.size() != seen.segments.size()) continue;  // the truth by pixels has another size
    for (std::size_t p = 0; p < mask.total(); ++p)
      if (const std::uint8_t segment = seen.segments.data[p]; segment != 0)
        ++home.shown[{i, segment}][mask.ptr<std::uint16_t>()[p]];
  }
  home.instances = map.instances();
  return home;
}

/// Pixels of each thing that the segments of an instance show.
Shown shownBy(const ObjectInstance& instance, const std::map<SegmentPlace, Shown>& shown) {
  Shown sum;
  for (const SegmentPlace& place : instance.segments)
    if (const auto segment = shown.find(place); segment != shown.end())
      for (const auto& [id, pixels] : segment->second) sum[id] += pixels;
  return sum;
}

/// How many things are in several instances, and how many instances are several things: a quarter of its
/// pixels or more are of another one than the most.
void countSplits(const HomeMap& home, CellResults& results) {
  std::map<int, int> instancesOf;
  double merged = 0;
  for (const ObjectInstance& instance : home.instances) {
    const Shown shown = shownBy(instance, home.shown);
    double all = 0, most = 0, second = 0;
    int thing = 0;
    for (const auto& [id, pixels] : shown) {
      all += pixels;
      if (pixels > most) {
        second = thing >= io::kFirstInstance ? most : 0;
        most = pixels;
        thing = id;
      } else if (id >= io::kFirstInstance) {
        second = std::max(second, pixels);
      }
    }
    if (thing >= io::kFirstInstance) ++instancesOf[thing];
    merged += second >= all / 4 && second > 0 ? 1 : 0;
  }
  const auto split = std::count_if(instancesOf.begin(), instancesOf.end(),
                                   [](const auto& instances) { return instances.second > 1; });
  results.push_back({"split", kCounted, static_cast<double>(split)});
  results.push_back({"merged", kCounted, merged});
}

struct ObjectScore {
  double things = 0, found = 0, instances = 0, right = 0;
  std::vector<double> errors = {};
};

CellResults scoreHome(const std::filesystem::path& folder, double noise,
                      const HomeSegmentationOptions& options) {
  const io::HomeTruth truth = io::readHomeTruth(folder);
  const HomeMap home = mapHome(folder, noise, options);
  std::map<int, int> framesOf;
  for (const auto& [image, things] : truth.visible)
    for (const io::VisibleInstance& thing : things)
      if (thing.pixels >= static_cast<int>(options.leastPixels)) ++framesOf[thing.id];
  std::vector<OrientedBox> found, things;
  for (const ObjectInstance& instance : home.instances) found.push_back(instance.box);
  for (const io::HomeInstance& thing : truth.instances)
    things.push_back({thing.center, thing.size, thing.yaw});
  std::vector<int> thingOf(found.size(), -1), foundBy(things.size(), -1);
  for (const BoxMatch& match : matchBoxes(found, things)) {
    thingOf[match.found] = static_cast<int>(match.thing);
    foundBy[match.thing] = static_cast<int>(match.found);
  }
  const auto classOf = [&](std::size_t thing) {
    const auto known = options.classOf.find(truth.instances[thing].category);
    return known == options.classOf.end() ? options.otherClass : known->second;
  };
  std::map<std::string, ObjectScore> scores;
  for (std::size_t t = 0; t < things.size(); ++t) {
    if (framesOf[truth.instances[t].id] < leastFrames) continue;
    const std::string name = classOf(t);
    for (const std::string& of : {name, kCounted}) {
      if (of == kCounted && name == kApart) continue;
      ObjectScore& score = scores[of];
      ++score.things;
      if (foundBy[t] < 0) continue;
      ++score.found;
      score.errors.push_back(cv::norm(things[t].center - found[static_cast<std::size_t>(foundBy[t])].center));
    }
  }
  for (std::size_t f = 0; f < found.size(); ++f) {
    const std::string name = thingOf[f] < 0 ? "none" : classOf(static_cast<std::size_t>(thingOf[f]));
    const bool hangs = home.instances[f].stands == ObjectInstance::Stands::wall;
    for (const std::string& of : {name, kCounted}) {
      if (of == kCounted && (name == kApart || (name == "none" && hangs))) continue;
      ++scores[of].instances;
      scores[of].right += thingOf[f] >= 0 ? 1 : 0;
    }
  }
  CellResults results;
  for (auto& [name, score] : scores) {
    for (const auto& [measure, value] :
         {std::pair{"things", score.things}, std::pair{"found", score.found},
          std::pair{"instances", score.instances}, std::pair{"right", score.right}})
      results.push_back({measure, name, value});
    if (score.errors.empty()) continue;
    std::ranges::sort(score.errors);
    results.push_back({"error", name, score.errors[score.errors.size() / 2]});
  }
  countSplits(home, results);
  return results;
}

struct ObjectRow {
  double things = 0, found = 0, instances = 0, right = 0;
  std::optional<double> error, split, merged;
};

ResultTable objectTable(const std::string& title, const CellResults& results) {
  std::vector<std::pair<std::string, ObjectRow>> rows;
  for (const CellResult& result : results) {
    if (result.measure != "instances") continue;
    const auto get = [&](const char* measure) { return valueOf(results, measure, result.at); };
    rows.push_back({result.at,
                    {get("things").value_or(0), get("found").value_or(0), result.value,
                     get("right").value_or(0), get("error"), get("split"), get("merged")}});
  }
  std::stable_partition(rows.begin(), rows.end(), [](const auto& row) { return row.first != kCounted; });
  const auto share = [](double part, double whole) {
    return whole > 0 ? CellValue(part / whole) : CellValue();
  };
  const auto given = [](const std::optional<double>& value) {
    return value ? CellValue(*value) : CellValue();
  };
  return pivot<ObjectRow>(
      {title,
       "Found: the box of an instance and that of the thing have an intersection over union of 0.25 or more, "
       "one to one. Split: things that most pixels of several instances show. Merged: instances of which "
       "another thing has a quarter of the pixels or more. Instances that hang at a wall and are no thing "
       "count neither way.",
       "class",
       {},
       {}},
      rows,
      {{{"things", 0}, [](auto& s) { return s.things; }},
       {{"found", 0}, [](auto& s) { return s.found; }},
       {{"recall", 3}, [=](auto& s) { return share(s.found, s.things); }},
       {{"instances", 0}, [](auto& s) { return s.instances; }},
       {{"right", 0}, [](auto& s) { return s.right; }},
       {{"precision", 3}, [=](auto& s) { return share(s.right, s.instances); }},
       {{"error [m]", 3}, [=](auto& s) { return given(s.error); }},
       {{"split", 0}, [=](auto& s) { return given(s.split); }},
       {{"merged", 0}, [=](auto& s) { return given(s.merged); }}});
}

}  // namespace

GridColumns homeObjectColumns() {
  return {{"drive", "noise"}, "class", {"things", "found", "instances", "right", "error", "split", "merged"}};
}

Findings findHomeObjects(const HomeSegmentationOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress) {
  refuseModels(run, "objects");
  std::string classes = options.otherClass;
  for (const auto& [category, name] : options.classOf) classes += " " + category + "=" + name;
  std::vector<Cell> cells;
  std::vector<std::pair<std::filesystem::path, double>> runs;
  for (const std::string& folder : options.drives)
    for (const double noise : options.noise) {
      runs.emplace_back(folder, noise);
      cells.push_back({{runs.back().first.filename().string(), fmt::format("{}", noise)},
                       sha256(fmt::format("{} {} {} {} {} {} {} {}", homeObjectsVersion, folder,
                                          sha256OfFile(runs.back().first / "instances.csv"), noise,
                                          options.every, options.leastPixels, options.seed, classes))});
    }
  const auto found = grid.run(
      cells, [&](std::size_t i) { return scoreHome(runs[i].first, runs[i].second, options); }, progress,
      "mapping objects");
  Findings findings;
  findings.title = "Objects of a home";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto get = [&](const char* measure) { return valueOf(found[i], measure, kCounted).value_or(0); };
    findings.summary += fmt::format("{}{}, noise {}: {} of {} things found, {} of {} instances right.",
                                    i == 0 ? "" : " ", cells[i].coordinates[0], cells[i].coordinates[1],
                                    get("found"), get("things"), get("right"), get("instances"));
    findings.sections.emplace_back(objectTable(
        fmt::format("{}, noise {} m at 1 m", cells[i].coordinates[0], cells[i].coordinates[1]), found[i]));
  }
  findings.facts = {{"Frames", options.every == 1 ? "all" : fmt::format("one of {}", options.every)},
                    {"Things", fmt::format("that {} frames or more show with {} pixels or more", leastFrames,
                                           options.leastPixels)},
                    {"Poses", "true"}};
  return findings;
}

}  // namespace estancia::experiments
