#include "estancia/recognition/dense_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/core/parallel.hpp"
#include "estancia/recognition/different_poses.hpp"

namespace estancia {
namespace {

constexpr double alike = 0.15;  // [rad] between two poses that are one

std::vector<TriedPose> bestOf(std::vector<TriedPose> poses, const cv::Point3d& center, double apart,
                              std::size_t most) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const TriedPose& a, const TriedPose& b) { return a.score > b.score; });
  return differentPoses(std::move(poses), center, apart, std::cos(alike), most);
}

template <class Work>
void each(std::size_t count, std::size_t together, int threads, const Work& work) {
  Progress silent;
  inParallel((count + together - 1) / together, threads, silent, "stopped while poses were tried",
             [&](std::size_t chunk) {
               for (std::size_t i = chunk * together; i < std::min(count, (chunk + 1) * together); ++i)
                 work(i);
             });
}

}  // namespace

double evidenceFor(const PoseScore& agreement, double tried, bool closed) {
  constexpr double wholeArea = 700;
  constexpr double leastPart = 0.25;
  const double part = closed ? std::clamp(agreement.facing, leastPart, 1.0) : 1;
  return agreement.vote() / part * std::sqrt(part * tried / wholeArea);
}

std::vector<TriedPose> posesOfFrames(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                     const std::vector<Match>& matches, const DenseModel& tried,
                                     const DenseScene& there, const RecognitionScales& scales,
                                     std::size_t most, int threads) {
  const PoseTolerances limits{6 * scales.unit + scales.noise, 10 * scales.unit + 1.5 * scales.noise, 0.5};
  const auto poseOf = [&](const Match& match) {
    const cv::Matx33d turn = cv::Matx33d(scene.frames[match.scene].t() * model.frames[match.model]);
    const cv::Vec3d from(cv::Point3d(model.points[match.model])), to(cv::Point3d(scene.points[match.scene]));
    return cv::Affine3d(turn, to - turn * from);
  };
  // Most poses are nonsense, and a quarter of the points tells.
  constexpr std::size_t part = 4, often = 5;
  OrientedPoints quarter;
  for (std::size_t i = 0; i < tried.few.points.size(); i += part) {
    quarter.points.push_back(tried.few.points[i]);
    quarter.normals.push_back(tried.few.normals[i]);
    if (!tried.few.weights.empty()) quarter.weights.push_back(tried.few.weights[i]);
  }
  std::vector<std::pair<double, std::size_t>> order(matches.size());
  each(matches.size(), 256, threads, [&](std::size_t i) {
    order[i] = {-scorePose(quarter, there, poseOf(matches[i]), limits).vote(), i};
  });
  const std::size_t left = std::min(order.size(), std::max(order.size() / often, 10 * most));
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(left), order.end());
  std::vector<TriedPose> poses(left);
  each(left, 64, threads, [&](std::size_t i) {
    TriedPose& p = poses[i];
    p.pose = poseOf(matches[order[i].second]);
    p.agreement = scorePose(tried.few, there, p.pose, limits);
    p.score = p.agreement.vote();
  });
  return bestOf(std::move(poses), tried.center, 6 * scales.unit, most);
}

std::vector<TriedPose> refinePoses(std::vector<TriedPose> poses, const DenseModel& tried,
                                   const DenseScene& there, const RecognitionScales& scales, int threads) {
  constexpr std::size_t promising = 30;
  const double unit = scales.unit, noise = scales.noise;
  // A small model has more points than the scene, which cannot confirm what it has not measured.
  const double seen = std::pow(std::min(1.0, unit / std::max(scales.spacing, unit)), 2);
  each(poses.size(), 4, threads, [&](std::size_t i) {
    TriedPose& p = poses[i];
    p.pose = refineInField(tried.few, tried.center, there, p.pose, {10 * unit, 6 * unit, 10});
    p.agreement = scorePose(tried.few, there, p.pose, {4 * unit, 7.5 * unit + noise, 0.65});
    p.score = p.agreement.vote();
  });
  poses = bestOf(std::move(poses), tried.center, 5 * unit, promising);
  each(poses.size(), 1, threads, [&](std::size_t i) {
    TriedPose& p = poses[i];
    p.pose = refineInField(tried.many, tried.center, there, p.pose, {7.5 * unit, 3 * unit + 0.2 * noise, 15});
    p.agreement = scorePose(tried.many, there, p.pose, {scales.tolerance, 6 * unit + noise, 0.7});
    p.score = evidenceFor(p.agreement, seen * static_cast<double>(tried.many.points.size()),
                          tried.closed && there.view.known());
  });
  return bestOf(std::move(poses), tried.center, 5 * unit, promising);
}

}  // namespace estancia
