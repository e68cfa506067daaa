// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/stage_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace estancia {
namespace {

int percent(double share) {
  return static_cast<int>(std::lround(100 * share));
}

std::string supportOfBest(const std::vector<PoseHypothesis>& poses) {
  return poses.empty() ? "" : fmt::format(", the best {} % supported", percent(poses[0].score.supported));
}

std::string inliersOfBest(const std::vector<PoseHypothesis>& poses) {
  if (poses.empty()) return "";
  const InlierCounts& counts = poses[0].counts;
  return fmt::format(", the best confirmed by {} of {} points, {:.2f} of what should be seen", counts.inliers,
                     counts.facing, counts.confidence());
}

/// Describes the best pose, accepted or not: "; best pose 0.19 of 0.25 needed, where wrong poses reach 0.12:
/// 41 % supported, 12 % seen through".
std::string comparison(const std::vector<PoseHypothesis>& poses, const FalseAlarmModel& falseAlarms,
                       double rate) {
  if (poses.empty()) return "";
  const PoseScore& a = poses[0].score;
  return fmt::format(
      "; best pose {:.2f} of {:.2f} needed, where wrong poses reach {:.2f}: false alarm rate {:.1e} of {:g} "
      "allowed; {} % supported, {} % seen through, {} % elsewhere, {} % hidden, {} % turned away",
      poses[0].evidence, falseAlarms.evidenceOf(rate), falseAlarms.chance(),
      falseAlarms.rate(poses[0].evidence), rate, percent(a.supported), percent(a.seenThrough + a.behind),
      percent(a.mismatched), percent(a.occluded), percent(1 - a.facing));
}

}  // namespace

void StageLog::add(const std::string& stage, std::string detail) {
  const auto now = std::chrono::steady_clock::now();
  if (stages_ != nullptr)
    stages_->push_back({stage, std::move(detail), std::chrono::duration<double>(now - last_).count()});
  last_ = now;
}

void StageLog::append(const std::vector<StageReport>& stages, const std::string& prefix) {
  if (stages_ == nullptr) return;
  for (const StageReport& s : stages) stages_->push_back({prefix + s.stage, s.detail, s.seconds});
}

void StageLog::matched(const RecognitionOptions& options, std::size_t modelKeypoints,
                       std::size_t sceneKeypoints, std::size_t matches) {
  add("matching", fmt::format("each of the {} keypoints of the {} with {}: {} matches",
                              options.matchEach == "scene" ? sceneKeypoints : modelKeypoints,
                              options.matchEach, options.neighbors, matches));
}

void StageLog::grouped(const RecognitionOptions& options, double consistency,
                       const std::vector<PoseHypothesis>& poses) {
  if (options.grouping == "local-frames")
    add("grouping", fmt::format("local-frames: {} poses{}", poses.size(), supportOfBest(poses)));
  else
    add("grouping", fmt::format("{}, {:.4g} m: {} poses, {} matches agree on the first", options.grouping,
                                consistency, poses.size(), poses.empty() ? 0 : poses[0].matches));
}

void StageLog::refined(const RecognitionOptions& options, const std::vector<PoseHypothesis>& poses) {
  add("refinement",
      fmt::format("{} different poses{}", poses.size(),
                  options.verification == "evidence" ? supportOfBest(poses) : inliersOfBest(poses)));
}

void StageLog::verified(const RecognitionOptions& options, const std::vector<PoseHypothesis>& refined,
                        const Instances& instances) {
  add("verification", fmt::format("{}: {} instances{}", options.verification, instances.poses.size(),
                                  options.verification == "evidence"
                                      ? comparison(refined, instances.falseAlarms, options.falseAlarmRate)
                                      : ""));
}

}  // namespace estancia
