// SPDX-License-Identifier: Apache-2.0
#include "objects/home_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/core.hpp>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/objects/instance_accuracy.hpp"
#include "estancia/objects/instance_map.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/world_file/observation.hpp"
#include "findings/pivot.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace {

constexpr int homeObjectsVersion = 3;  // version of the code below: drives of another one are mapped anew
const std::string countedRow = "all but fixture";

struct HomeMap {
  std::vector<ObjectInstance> instances;
  std::map<SegmentPlace, PixelsOfThings> pixels;
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
    addPixels(i, seen.segments, io::readInstanceMask(io::instanceMaskFile(folder, sequence.frame(i))),
              home.pixels);
  }
  home.instances = map.instances();
  return home;
}

CellResults scoreHome(const std::filesystem::path& folder, double noise,
                      const HomeSegmentationOptions& options) {
  const HomeMap home = mapHome(folder, noise, options);
  std::vector<FoundInstance> found;
  for (const ObjectInstance& instance : home.instances) {
    auto& one =
        found.emplace_back(FoundInstance{instance.box, instance.stands == ObjectInstance::Stands::wall});
    for (const SegmentPlace& place : instance.segments)
      if (const auto shown = home.pixels.find(place); shown != home.pixels.end())
        for (const auto& [id, pixels] : shown->second) one.pixels[id] += pixels;
  }
  const InstanceAccuracy accuracy = judgeInstances(
      found, trueThings(io::readHomeTruth(folder), options.classes, nullptr, {}, options.minPixels));
  std::map<std::string, InstanceScore> scores = accuracy.ofClass;
  scores[countedRow] = accuracy.counted;
  CellResults results;
  for (const auto& [name, score] : scores) {
    for (const auto& [measure, value] :
         {std::pair{"things", score.things}, std::pair{"found", score.found},
          std::pair{"instances", score.instances}, std::pair{"right", score.right}})
      results.push_back({measure, name, static_cast<double>(value)});
    if (score.error) results.push_back({"error", name, *score.error});
  }
  results.push_back({"split", countedRow, static_cast<double>(accuracy.split.value_or(0))});
  results.push_back({"merged", countedRow, static_cast<double>(accuracy.merged.value_or(0))});
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
  std::stable_partition(rows.begin(), rows.end(), [](const auto& row) { return row.first != countedRow; });
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
  const std::string classes = classesText(options.classes);
  std::vector<Cell> cells;
  std::vector<std::pair<std::filesystem::path, double>> runs;
  for (const std::string& folder : options.drives)
    for (const double noise : options.noise) {
      runs.emplace_back(folder, noise);
      cells.push_back({{runs.back().first.filename().string(), fmt::format("{}", noise)},
                       sha256(fmt::format("{} {} {} {} {} {} {} {}", homeObjectsVersion, folder,
                                          sha256OfFile(runs.back().first / "instances.csv"), noise,
                                          options.every, options.minPixels, options.seed, classes))});
    }
  const auto found = grid.run(
      cells, [&](std::size_t i) { return scoreHome(runs[i].first, runs[i].second, options); }, progress,
      "mapping objects");
  Findings findings;
  findings.title = "Objects of a home";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto get = [&](const char* measure) { return valueOf(found[i], measure, countedRow).value_or(0); };
    findings.summary += fmt::format("{}{}, noise {}: {} of {} things found, {} of {} instances right.",
                                    i == 0 ? "" : " ", cells[i].coordinates[0], cells[i].coordinates[1],
                                    get("found"), get("things"), get("right"), get("instances"));
    findings.sections.emplace_back(objectTable(
        fmt::format("{}, noise {} m at 1 m", cells[i].coordinates[0], cells[i].coordinates[1]), found[i]));
  }
  findings.facts = {{"Frames", options.every == 1 ? "all" : fmt::format("one of {}", options.every)},
                    {"Things", fmt::format("that {} frames or more show with {} pixels or more",
                                           minFramesOfThing, options.minPixels)},
                    {"Poses", "true"}};
  return findings;
}

}  // namespace estancia::experiments
