// SPDX-License-Identifier: Apache-2.0
#include "odometry/odometry_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>
#include <unordered_map>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/stats/trajectory_error.hpp"
#include "runner/config_lists.hpp"

namespace estancia::experiments {
namespace {

constexpr int odometryErrorsVersion = 4;  // version of the code below: cells of another one are computed anew

/// The words of a drive's frames, by their numbers; empty where an image could not be read.
std::vector<LexicalDescriptor> wordsOf(const Sequence& images, const DescriptorSequence& recording) {
  std::unordered_map<std::string, std::size_t> rows;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) rows.emplace(recording.frames[i].name, i);
  std::vector<LexicalDescriptor> words(images.size());
  for (std::size_t i = 0; i < images.size(); ++i)
    if (const auto row = rows.find(images.frame(i).name); row != rows.end()) {
      const DescriptorView view = recording.descriptors.row(row->second);
      words[i].assign(view.begin(), view.end());
    }
  return words;
}

/// Estimated poses, and the true ones of the same frames.
struct PosePairs {
  std::vector<Pose> estimated, truth;
};

PosePairs pairsOf(const std::vector<std::optional<Pose>>& estimated, const Sequence& sequence) {
  PosePairs pairs;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (estimated[i] && sequence.frame(i).pose) {
      pairs.estimated.push_back(*estimated[i]);
      pairs.truth.push_back(*sequence.frame(i).pose);
    }
  return pairs;
}

CellResults compareWithTruth(const Sequence& sequence, const RgbdTrajectory& trajectory) {
  const auto placed = static_cast<double>(
      std::ranges::count_if(trajectory.poses, [](const auto& pose) { return pose.has_value(); }));
  CellResults results{{"frames", "", static_cast<double>(sequence.size())},
                      {"placed", "", placed},
                      {"bridged", "", static_cast<double>(trajectory.bridged.size())},
                      {"keyframes", "", static_cast<double>(trajectory.keyframes.size())},
                      {"loops", "", static_cast<double>(trajectory.loops.size())},
                      {"corrections", "", static_cast<double>(trajectory.corrections)}};
  const auto [estimated, truth] = pairsOf(trajectory.poses, sequence);
  if (truth.empty()) return results;
  const AbsoluteTrajectoryError absolute = absoluteTrajectoryError(estimated, truth);
  const RelativePoseError relative = relativePoseError(estimated, truth);
  for (const auto& [measure, value] : {std::pair{"path", pathLength(truth)},
                                       {"rmse", absolute.rmse},
                                       {"median", absolute.median},
                                       {"max", absolute.max},
                                       {"relative_translation", relative.translationRmse},
                                       {"relative_rotation", relative.rotationRmse}})
    results.push_back({measure, "", value});
  const auto [online, seen] = pairsOf(trajectory.online, sequence);
  if (!seen.empty()) results.push_back({"online_rmse", "", absoluteTrajectoryError(online, seen).rmse});
  return results;
}

void requirePoses(const NamedDrive& drive, const Sequence& images) {
  for (std::size_t i = 0; i < images.size(); ++i)
    if (images.frame(i).pose) return;
  throw Error(ErrorCode::insufficientData,
              fmt::format("{}: no frame has a true pose to compare with; give them by `poses = \"FILE\"`",
                          drive.images.path.string()));
}

CellResults track(LabeledDrives& labeled, const NamedDrive& drive, DriveAlteration alteration,
                  std::uint64_t seed) {
  const auto& [images, recording] = labeled.of(drive.images);
  requirePoses(drive, *images);
  alteration.seed = seed;
  const AlteredDrive altered(images, alteration);
  const std::vector<LexicalDescriptor> described = wordsOf(*images, recording);
  const FrameWords words{[&](std::size_t frame) { return described.at(altered.original(frame)); },
                         labeled.vocabulary().layout().parts};
  return compareWithTruth(altered, trackRgbd(altered, {}, words, labeled.progress(), altered.wheels()));
}

OptionGroup declare(OdometryErrorsOptions::Variant& variant) {
  OptionGroup group("variant", "How a drive is altered.");
  group.add("name", &variant.name, "What to call it");
  group.add("every", &variant.alteration.every, "Only every so many-th frame").range(1, 1000);
  group.add("noise", &variant.alteration.noise, "k of the depth's deviation k z²").unit("1/m").range(0, 1);
  group
      .add("wheel-shift", &variant.alteration.wheelShift, "Deviation of a step's length as wheels measure it")
      .unit("%")
      .range(0, 100);
  group.add("wheel-turn", &variant.alteration.wheelTurn, "Deviation of a step's turn as wheels measure it")
      .unit("degrees")
      .range(0, 90);
  return group;
}

OptionGroup declare(OdometryErrorsOptions& options) {
  OptionGroup group("odometry", "Trajectories beside the true ones.");
  group.add("seed", &options.seed, "Seed of the noise").range(0, 1e9);
  return group;
}

}  // namespace

OdometryErrorsOptions readOdometryErrors(ConfigFile& config) {
  OdometryErrorsOptions options;
  const toml::array *drives = nullptr, *variants = nullptr;
  config.read(together(
      keysOf(config, declare(options)),
      {{"type", true, "the kind of experiment", [](auto&) {}},
       {"models", false, "whose words propose loops",
        each(config, options.models, [&config](const toml::node& n) { return config.text(n); })},
       {"variant", false, "[[variant]] alters the drives", [&](auto& n) { variants = &config.list(n); }},
       {"drive", true, "[[drive]] names images with depth and poses",
        [&](auto& n) { drives = &config.list(n); }}}));
  for (const toml::node& node : *drives)
    options.drives.push_back(readNamedDrive(config, config.subtable(node)));
  std::set<std::string> names;
  if (variants != nullptr)
    for (const toml::node& node : *variants) {
      auto& variant = options.variants.emplace_back();
      config.read(config.subtable(node), requiring("name", keysOf(config, declare(variant))));
      if (!names.insert(variant.name).second)
        config.fail(node, fmt::format("two variants are called {}; tell them apart by `name`", variant.name));
    }
  if (options.variants.empty()) options.variants.push_back({"as it is", {}});
  return options;
}

GridColumns odometryErrorsColumns() {
  return {{"model", "drive", "variant"},
          "",
          {"frames", "placed", "bridged", "keyframes", "loops", "corrections", "path", "rmse", "median",
           "max", "online_rmse", "relative_translation", "relative_rotation"}};
}

Findings compareOdometry(const OdometryErrorsOptions& options, Grid& grid, const ExperimentRun& run,
                         Progress& progress) {
  const auto inputs = [&](const NamedDrive&, std::size_t v) {
    const DriveAlteration& altered = options.variants[v].alteration;
    return fmt::format("{} {} {} {} {} {}", odometryErrorsVersion, altered.every, altered.noise,
                       altered.wheelShift, altered.wheelTurn, options.seed);
  };
  const auto compute = [&](LabeledDrives& labeled, const NamedDrive& drive, std::size_t v) {
    return track(labeled, drive, options.variants[v].alteration, options.seed);
  };
  return studyDrives({options.models, options.drives, namesIn(options.variants), inputs, compute},
                     odometryFindings, grid, run, progress);
}

Findings odometryFindings(const DriveResults& results) {
  constexpr auto smallest = ResultTable::Best::smallest;
  const auto measures =
      measuresIn(results.cells, {{"frames", {"frames", 0}},
                                 {"placed", {"placed", 0}},
                                 {"bridged", {"bridged", 0}},
                                 {"keyframes", {"keyframes", 0}},
                                 {"loops", {"loops", 0}},
                                 {"path", {"path [m]", 1}},
                                 {"rmse", {"RMSE [m]", 3, smallest}},
                                 {"median", {"median [m]", 3, smallest}},
                                 {"max", {"worst [m]", 3, smallest}},
                                 {"online_rmse", {"online RMSE [m]", 3, smallest}},
                                 {"corrections", {"corrections", 0}},
                                 {"relative_translation", {"frame to frame [m]", 4, smallest}},
                                 {"relative_rotation", {"frame to frame [°]", 2, smallest}}});
  Findings findings;
  findings.title = "Odometry beside the truth";
  results.each([&](std::size_t model, std::size_t drive) {
    std::vector<std::pair<std::string, CellResults>> rows;
    for (std::size_t v = 0; v < results.variants.size(); ++v)
      rows.emplace_back(results.variants[v], results.of(model, drive, v));
    findings.sections.emplace_back(pivot(
        ResultTable{
            results.titleOf(model, drive),
            "Bridged: placed without being tracked. Distances of the placed frames to their "
            "true positions after the best rigid alignment "
            "(ATE), online: of the poses as they were when each frame had just been seen; corrections "
            "are the times that earlier poses changed since; errors of the motion from one placed "
            "frame to the next (RPE).",
            "drive",
            {},
            {}},
        rows, measures));
  });
  findings.summary = fmt::format("{} drives in {} variants, tracked with the defaults.",
                                 results.drives.size(), results.variants.size());
  return findings;
}

}  // namespace estancia::experiments
