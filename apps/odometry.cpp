// estancia odometry: where the camera stood in every image of an RGB-D sequence.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/sequences/trajectory.hpp"
#include "estancia/stats/trajectory_error.hpp"
#include "labeling.hpp"
#include "tracked.hpp"

namespace estancia::apps {
namespace {

struct OdometryArguments {
  explicit OdometryArguments(CLI::App& command) : declared(command) {}
  SequenceArguments sequence;
  ModelArguments model;
  RgbdOptions options;
  DeclaredOptions declared;
  std::string output, odom;
  bool noLoops = false, overwrite = false, json = false;
};

/// The poses of `file`, matched to the frames as --poses would be.
MotionPrior readPrior(const SequenceArguments& sequence, const std::string& file) {
  SequenceArguments other = sequence;
  other.options.poses = file;
  const auto moved = other.openQuietly();
  MotionPrior prior;
  for (std::size_t i = 0; i < moved->size(); ++i) prior.push_back(moved->frame(i).pose);
  const auto unknown = std::ranges::count_if(prior, [](const auto& pose) { return !pose; });
  if (unknown == std::ssize(prior))
    throw Error(ErrorCode::invalidInput,
                fmt::format("{}: none of its poses belongs to a frame of {}; check its time stamps", file,
                            sequence.path));
  if (unknown > 0)
    spdlog::warn("{}: no pose for {} of {} frames; there the images stand alone", file, unknown,
                 prior.size());
  return prior;
}

/// The estimate beside the poses that the sequence came with.
struct Comparison {
  AbsoluteTrajectoryError absolute;
  RelativePoseError relative;
  double path = 0;    ///< length of the true poses that were estimated [m]
  double online = 0;  ///< RMSE of the poses as they were when each frame had just been seen [m]
};

/// Estimated poses, and the true ones of the same frames.
struct PosePairs {
  std::vector<Pose> estimated, truth;
};

PosePairs pairsOf(const Sequence& sequence, const std::vector<std::optional<Pose>>& estimated) {
  PosePairs pairs;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (estimated[i] && sequence.frame(i).pose) {
      pairs.estimated.push_back(*estimated[i]);
      pairs.truth.push_back(*sequence.frame(i).pose);
    }
  return pairs;
}

std::optional<Comparison> compareWithTruth(const Sequence& sequence, const RgbdTrajectory& trajectory) {
  const auto [estimated, truth] = pairsOf(sequence, trajectory.poses);
  const auto [online, seen] = pairsOf(sequence, trajectory.online);
  if (truth.empty() || seen.empty()) return std::nullopt;
  return Comparison{absoluteTrajectoryError(estimated, truth), relativePoseError(estimated, truth),
                    pathLength(truth), absoluteTrajectoryError(online, seen).rmse};
}

void tell(const OdometryArguments& arguments, const Sequence& sequence, const RgbdTrajectory& trajectory,
          double seconds) {
  const double rate = static_cast<double>(sequence.size()) / seconds;
  const auto comparison = compareWithTruth(sequence, trajectory);
  if (arguments.json) {
    nlohmann::ordered_json json{{"trajectory", arguments.output}, {"frames", sequence.size()}};
    addCounts(json, trajectory);
    json["frames_per_second"] = rate;
    addUntracked(json, trajectory, [&](std::size_t frame) { return sequence.frame(frame).name; });
    if (comparison)
      json["error"] = {{"poses", comparison->absolute.poses},
                       {"rmse", comparison->absolute.rmse},
                       {"online_rmse", comparison->online},
                       {"mean", comparison->absolute.mean},
                       {"median", comparison->absolute.median},
                       {"max", comparison->absolute.max},
                       {"path", comparison->path},
                       {"relative_translation", comparison->relative.translationRmse},
                       {"relative_rotation", comparison->relative.rotationRmse}};
    print(json);
    return;
  }
  fmt::print("{}: {} of {} frames placed, {} of them bridged, {} keyframes, {} loops; {:.1f} frames/s\n",
             printable(arguments.output), sequence.size() - trajectory.lost.size(), sequence.size(),
             trajectory.bridged.size(), trajectory.keyframes.size(), trajectory.loops.size(), rate);
  if (!comparison) return;
  const auto& [absolute, relative, path, online] = *comparison;
  fmt::print(
      "beside the poses of the sequence, {} of them, a path of {:.2f} m: off by {:.3f} m (root mean square; "
      "median {:.3f}, most {:.3f}",
      absolute.poses, path, absolute.rmse, absolute.median, absolute.max);
  if (path > 0)
    fmt::print("), {:.1f} % of the path", 100 * absolute.rmse / path);
  else
    fmt::print(")");
  fmt::print(
      "; from frame to frame by {:.3f} m and {:.2f}°; when each frame had just been seen by {:.3f} m\n",
      relative.translationRmse, relative.rotationRmse, online);
}

void run(const OdometryArguments& arguments) {
  requireNoData(arguments.output,
                {arguments.sequence.path, arguments.sequence.options.poses, arguments.odom});
  requireReplaceable(arguments.output, arguments.overwrite, nullptr, "trajectory");

  std::unique_ptr<Sequence> unlabeled;
  std::unique_ptr<Labeling> labeling;
  FrameWords words;
  if (arguments.options.loopCandidates == 0) {
    unlabeled = arguments.sequence.open();
  } else {
    labeling = std::make_unique<Labeling>(arguments.sequence, arguments.model);
    words.describe = [&labeling](std::size_t frame) { return labeling->words(frame); };
    words.parts = labeling->vocabulary().layout().parts;
  }
  const Sequence& sequence = labeling ? labeling->sequence() : *unlabeled;

  const MotionPrior prior =
      arguments.odom.empty() ? MotionPrior() : readPrior(arguments.sequence, arguments.odom);
  const auto start = std::chrono::steady_clock::now();
  const auto progress = makeStderrProgress();
  const RgbdTrajectory trajectory = trackRgbd(sequence, arguments.options, words, *progress, prior);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  warnOfUntracked(
      trajectory, [&](std::size_t frame) { return sequence.frame(frame).name; },
      arguments.odom.empty() ? "a steady motion" : "--odom");

  std::vector<Frame> frames;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    frames.push_back(sequence.frame(i));
    frames.back().pose = trajectory.poses[i];
  }
  writePoses(frames, arguments.output);
  tell(arguments, sequence, trajectory, seconds.count());
}

}  // namespace

void addOdometryCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand("odometry", "Estimate camera poses of images with depth");
  group->require_subcommand(1);
  addExamples(*group, "  estancia odometry estimate ~/kitchen -o kitchen.txt");
  CLI::App* command = group->add_subcommand("estimate", "Estimate the camera pose of every image with depth");
  auto arguments = std::make_shared<OdometryArguments>(*command);
  command
      ->add_option("--odom", arguments->odom,
                   "The motion by another sensor, as wheels: a trajectory of the camera (TUM or KITTI)")
      ->type_name("FILE")
      ->check(CLI::ExistingFile);
  arguments->sequence.addTo(arguments->declared);
  arguments->sequence.addDepthTo(arguments->declared);
  addOutputOption(*command, arguments->output, "The trajectory (TUM), for --poses of the other commands")
      ->required();
  arguments->model.addTo(arguments->declared, "The model whose labels propose loop closures");
  arguments->declared.add(declare(arguments->options),
                          {"term", "max-width", "max-depth", "min-loop-features", "odom-shift", "odom-turn"});
  command->add_flag("--no-loops", arguments->noLoops, "Track only: no labels, no loop closures; drift stays");
  addOverwriteOption(*command, arguments->overwrite);
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia check ~/kitchen\n"
              "  estancia odometry estimate ~/kitchen -o kitchen.txt\n"
              "  estancia odometry estimate ~/kitchen --odom wheels.txt -o kitchen.txt\n"
              "  estancia map ~/kitchen --poses kitchen.txt -o kitchen.estancia");
  command->callback([arguments] {
    if (arguments->noLoops) arguments->options.loopCandidates = 0;
    run(*arguments);
  });
}

}  // namespace estancia::apps
