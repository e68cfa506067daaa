// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/dense_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {
namespace {

constexpr double minRotation = 0.15;  // [rad] between distinct poses

std::vector<PoseHypothesis> bestOf(std::vector<PoseHypothesis> poses, const cv::Point3d& center,
                                   double minDistance, std::size_t max) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.evidence > b.evidence; });
  return distinctPoses(std::move(poses), center, minDistance, std::cos(minRotation), max);
}

/// A part of the points, spread as they are.
OrientedPoints everyNth(const OrientedPoints& points, std::size_t n) {
  OrientedPoints part;
  for (std::size_t i = 0; i < points.points.size(); i += std::max<std::size_t>(n, 1)) {
    part.points.push_back(points.points[i]);
    part.normals.push_back(points.normals[i]);
    if (!points.weights.empty()) part.weights.push_back(points.weights[i]);
    if (!points.lab.empty()) part.lab.push_back(points.lab[i]);
  }
  return part;
}

template <class Work>
void each(std::size_t count, std::size_t together, int threads, const Work& work) {
  inChunks(count, together, threads, "stopped while poses were tried",
           [&](std::size_t first, std::size_t last) {
             for (std::size_t i = first; i < last; ++i) work(i);
           });
}

/// The evidence for a pose: the mean vote of its points times the square root of the area, because the same
/// share of a larger surface is less likely to be chance. The area is `points`, the number of points that
/// were tried, in units of 700 (less where the scene has fewer points than the model); of a closed model only
/// the points that face the sensor.
double evidenceFor(const PoseScore& score, double points, bool closed) {
  constexpr double unitArea = 700;
  constexpr double minFacing = 0.25;
  const double facing = closed ? std::clamp(score.facing, minFacing, 1.0) : 1;
  return score.vote() / facing * std::sqrt(facing * points / unitArea);
}

}  // namespace

PoseTolerances toleranceOf(const RecognitionScales& scales) {
  return {scales.tolerance, 6 * scales.unit + scales.noise, 0.7, scales.color};
}

std::vector<PoseHypothesis> posesFromLocalFrames(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                                 const std::vector<Match>& matches, const DenseModel& points,
                                                 const DenseScene& dense, const RecognitionScales& scales,
                                                 std::size_t max, int threads) {
  const PoseTolerances limits{.offset = 6 * scales.unit + scales.noise,
                              .freeSpace = 10 * scales.unit + 1.5 * scales.noise,
                              .minDot = 0.5,
                              .color = scales.color};
  const auto poseOf = [&](const Match& match) {
    const cv::Matx33d turn = cv::Matx33d(scene.frames[match.scene].t() * model.frames[match.model]);
    const cv::Vec3d from(cv::Point3d(model.points[match.model])), to(cv::Point3d(scene.points[match.scene]));
    return cv::Affine3d(turn, to - turn * from);
  };
  // Most poses are wrong, and a few points reject them: each round tries the best of the last with more
  // points (as preemptive RANSAC does: Nistér, ICCV 2003).
  struct Round {
    std::size_t points, kept;
  };
  const std::size_t some = 20 * max, few = 8 * max;
  std::vector<std::pair<double, std::size_t>> order(matches.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = {0, i};
  // Poses tried one after another look at the same part of the scene, which is in the cache.
  std::ranges::sort(order, {}, [&](const auto& o) { return std::pair(matches[o.second].scene, o.second); });
  for (const Round& round : {Round{32, std::max(some, matches.size() / 6)}, Round{96, few}}) {
    const OrientedPoints sample = everyNth(points.coarse, points.coarse.points.size() / round.points);
    each(order.size(), 256, threads, [&](std::size_t i) {
      order[i].first = -scorePose(sample, dense, poseOf(matches[order[i].second]), limits).vote();
    });
    const std::size_t kept = std::min(order.size(), round.kept);
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end());
    order.resize(kept);
  }
  std::vector<PoseHypothesis> poses(order.size());
  each(order.size(), 64, threads, [&](std::size_t i) {
    PoseHypothesis& p = poses[i];
    p.pose = poseOf(matches[order[i].second]);
    p.score = scorePose(points.coarse, dense, p.pose, limits);
    p.evidence = p.score.vote();
  });
  return bestOf(std::move(poses), points.center, 6 * scales.unit, max);
}

std::vector<PoseHypothesis> refineDense(std::vector<PoseHypothesis> poses, const DenseModel& points,
                                        const DenseScene& dense, const RecognitionScales& scales,
                                        int threads) {
  constexpr std::size_t maxFine = 30;
  const double unit = scales.unit, noise = scales.noise, color = scales.color;
  // A small model has more points than the scene, which cannot support what it has not measured.
  const double measured = std::pow(std::min(1.0, unit / std::max(scales.spacing, unit)), 2);
  each(poses.size(), 4, threads, [&](std::size_t i) {
    PoseHypothesis& p = poses[i];
    p.pose = refineInField(points.coarse, points.center, dense, p.pose, {10 * unit, 6 * unit, 10, color});
    p.score = scorePose(points.coarse, dense, p.pose, {4 * unit, 7.5 * unit + noise, 0.65, color});
    p.evidence = p.score.vote();
  });
  poses = bestOf(std::move(poses), points.center, 5 * unit, maxFine);
  each(poses.size(), 1, threads, [&](std::size_t i) {
    PoseHypothesis& p = poses[i];
    p.pose = refineInField(points.fine, points.center, dense, p.pose,
                           {7.5 * unit, 3 * unit + 0.2 * noise, 15, color});
    p.score = scorePose(points.fine, dense, p.pose, toleranceOf(scales));
    p.evidence = evidenceFor(p.score, measured * static_cast<double>(points.fine.points.size()),
                             points.closed && dense.view.known());
  });
  return bestOf(std::move(poses), points.center, 5 * unit, maxFine);
}

}  // namespace estancia
