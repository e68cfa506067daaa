// SPDX-License-Identifier: Apache-2.0
#include "objects/home_segmentation.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <set>

#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/segmentation/clusters.hpp"
#include "estancia/sequences/sequence.hpp"
#include "findings/pivot.hpp"
#include "runner/config_lists.hpp"
#include "runner/subjects.hpp"

namespace estancia::experiments {
namespace {

// version of the code below: drives of another one are segmented anew
constexpr int homeSegmentationVersion = 2;
const std::string allRow = "all", structureRow = "structure";  // rows beside those of classes
constexpr double mostly = 0.6;  // share of a thing in no cluster, from which on it was taken for structure

struct ClassScore {
  double things = 0, found = 0, structure = 0, clusters = 0, right = 0;
};
using ClassScores = std::map<std::string, ClassScore>;

/// The class of each instance.
using Classes = std::map<int, std::string>;

/// A cluster counts for the class of the thing that it has most of, and for "structure" where that is none.
void scoreHomeFrame(const Clusters& clusters, const cv::Mat& depth, const cv::Mat& mask,
                    const Classes& classes, std::size_t minPixels, ClassScores& scores) {
  const auto* id = mask.ptr<std::uint16_t>();
  std::map<int, double> sizes, best, clustered;
  for (std::size_t p = 0; p < mask.total(); ++p)
    if (depth.ptr<float>()[p] > 0) ++sizes[id[p]];
  for (const Cluster& cluster : clusters.clusters) {
    std::map<int, double> common;
    for (const std::uint32_t p : cluster.points) ++common[id[p]];
    double overlap = 0;
    for (const auto& [thing, both] : common) {
      clustered[thing] += both;
      if (thing < io::firstInstance) continue;
      const double iou = both / (sizes[thing] + static_cast<double>(cluster.points.size()) - both);
      best[thing] = std::max(best[thing], iou);
      overlap = std::max(overlap, iou);
    }
    const auto most = std::max_element(common.begin(), common.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    const auto known = classes.find(most->first);
    for (const std::string& name : {allRow, known == classes.end() ? structureRow : known->second}) {
      ++scores[name].clusters;
      scores[name].right += overlap >= 0.5 ? 1 : 0;
    }
  }
  for (const auto& [thing, size] : sizes) {
    if (thing < io::firstInstance || size < static_cast<double>(minPixels)) continue;
    for (const std::string& name : {allRow, classes.at(thing)}) {
      ++scores[name].things;
      scores[name].found += best[thing] >= 0.5 ? 1 : 0;
      scores[name].structure += clustered[thing] <= (1 - mostly) * size ? 1 : 0;
    }
  }
}

CellResults segmentDrive(const std::filesystem::path& drive, double noise,
                         const HomeSegmentationOptions& options) {
  const auto opened = openSequence(drive, {});
  const Sequence& sequence = *opened;
  const auto& camera = sequence.intrinsics();
  if (!sequence.hasDepth() || !camera)
    throw Error(ErrorCode::invalidInput,
                fmt::format("{} has no depth or no camera; segmentation needs both", drive.string()));
  Classes classes;
  for (const io::HomeInstance& thing : io::readHomeInstances(drive / "instances.csv"))
    classes[thing.id] = options.classes.of(thing.category);
  ClusterOptions clustering;
  clustering.threads = 1;  // drives are taken side by side
  ClassScores scores;
  for (std::size_t i = 0; i < sequence.size(); i += options.every) {
    cv::Mat depth = sequence.depth(i);
    cv::RNG random(options.seed + i);
    for (float& z : cv::Mat_<float>(depth))
      z += z > 0 ? static_cast<float>(random.gaussian(noise) * z * z) : 0;
    const cv::Mat mask = io::readInstanceMask(io::instanceMaskFile(drive, sequence.frame(i)));
    if (mask.size() != depth.size())
      throw Error(ErrorCode::mismatch, fmt::format("{}: masks and depth differ in size", drive.string()));
    scoreHomeFrame(findClusters(depth, *camera, clustering, sequence.image(i)), depth, mask, classes,
                   options.minPixels, scores);
  }
  CellResults results;
  for (const auto& [name, score] : scores)
    for (const auto& [measure, value] :
         {std::pair{"things", score.things}, std::pair{"found", score.found},
          std::pair{"structure", score.structure}, std::pair{"clusters", score.clusters},
          std::pair{"right", score.right}})
      results.push_back({measure, name, value});
  return results;
}

ResultTable tableOf(const std::string& title, const CellResults& results) {
  std::vector<std::pair<std::string, ClassScore>> rows;
  for (const CellResult& result : results) {
    if (result.measure != "things") continue;
    const auto get = [&](const char* measure) { return valueOf(results, measure, result.at).value_or(0); };
    rows.push_back(
        {result.at, {get("things"), get("found"), get("structure"), get("clusters"), get("right")}});
  }
  std::stable_partition(rows.begin(), rows.end(), [](const auto& row) { return row.first != allRow; });
  const auto share = [](double part, double whole) {
    return whole > 0 ? CellValue(part / whole) : CellValue();
  };
  return pivot<ClassScore>(
      {title,
       "Found: a cluster's intersection over union with the thing, over pixels with depth, is 0.5 or more. "
       "Taken for structure: 60 % or more of it is in no cluster. "
       "Right: that of the cluster with any thing is. A cluster counts for the class that it shows most of.",
       "class",
       {},
       {}},
      rows,
      {{{"things", 0}, [](auto& s) { return s.things; }},
       {{"found", 0}, [](auto& s) { return s.found; }},
       {{"recall", 3}, [=](auto& s) { return share(s.found, s.things); }},
       {{"taken for structure", 3}, [=](auto& s) { return share(s.structure, s.things); }},
       {{"clusters", 0}, [](auto& s) { return s.clusters; }},
       {{"right", 0}, [](auto& s) { return s.right; }},
       {{"precision", 3}, [=](auto& s) { return share(s.right, s.clusters); }}});
}

}  // namespace

std::string classesText(const ThingClasses& classes) {
  std::string text = classes.otherClass;
  for (const auto& [category, name] : classes.classOf) text += " " + category + "=" + name;
  return text;
}

HomeSegmentationOptions readHomeSegmentation(ConfigFile& config) {
  HomeSegmentationOptions options;
  OptionGroup group("home-segmentation", "Things found in a home.");
  group.add("every", &options.every, "Takes every such frame").range(1);
  group.add("least-pixels", &options.minPixels, "Pixels of the smallest thing that is to be found").range(1);
  group.add("seed", &options.seed, "Seed of the noise").range(0, 1e9);
  const auto drives = each(config, options.drives, [&](auto& n) { return config.anywhere(n).string(); });
  const auto noise = each(config, options.noise, [&](auto& n) { return config.number(n, 0, 1); });
  config.read(together(together(keysOf(config, std::move(group)),
                                thingClassKeys(config, options.classes, true, {allRow, structureRow})),
                       {{"type", true, "the kind of experiment", [](auto&) {}},
                        {"drives", true, "the folders of drives", drives},
                        {"noise", false, "standard deviations of noise [m at 1 m]", noise}}));
  return options;
}

GridColumns homeSegmentationColumns() {
  return {{"drive", "noise"}, "class", {"things", "found", "structure", "clusters", "right"}};
}

Findings segmentHomes(const HomeSegmentationOptions& options, Grid& grid, const ExperimentRun& run,
                      Progress& progress) {
  refuseModels(run, "segmentation");
  const std::string classes = classesText(options.classes);
  std::vector<Cell> cells;
  std::vector<std::pair<std::filesystem::path, double>> runs;
  std::set<std::string> present;
  for (const std::filesystem::path drive : options.drives) {
    for (const io::HomeInstance& thing : io::readHomeInstances(drive / "instances.csv"))
      present.insert(thing.category);
    for (const double noise : options.noise) {
      runs.emplace_back(drive, noise);
      cells.push_back({{drive.filename().string(), fmt::format("{}", noise)},
                       sha256(fmt::format("{} {} {} {} {} {} {} {}", homeSegmentationVersion, drive.string(),
                                          sha256OfFile(drive / "instances.csv"), noise, options.every,
                                          options.minPixels, options.seed, classes))});
    }
  }
  const auto found = grid.run(
      cells, [&](std::size_t i) { return segmentDrive(runs[i].first, runs[i].second, options); }, progress,
      "segmenting");
  Findings findings;
  findings.title = "Segmentation of a home";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string& drive = cells[i].coordinates[0];
    const auto get = [&](const char* measure) { return valueOf(found[i], measure, allRow).value_or(0); };
    findings.summary += fmt::format("{}{}, noise {}: {} of {} things found, {} of {} clusters right.",
                                    i == 0 ? "" : " ", drive, cells[i].coordinates[1], get("found"),
                                    get("things"), get("right"), get("clusters"));
    findings.sections.emplace_back(
        tableOf(fmt::format("{}, noise {} m at 1 m", drive, cells[i].coordinates[1]), found[i]));
  }
  findings.facts = {{"Frames", options.every == 1 ? "all" : fmt::format("one of {}", options.every)},
                    {"Things", fmt::format("of {} pixels or more", options.minPixels)},
                    {"Clusters", "of the library's defaults"}};
  std::vector<std::string> unknown;
  for (const auto& [category, name] : options.classes.classOf)
    if (!present.contains(category)) unknown.push_back(category);
  if (!unknown.empty())
    findings.notes.push_back(
        fmt::format("No drive has a thing of these categories: {}.", fmt::join(unknown, ", ")));
  return findings;
}

}  // namespace estancia::experiments
