// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/grouping.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "estancia/core/fail.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/simd.hpp"

namespace estancia {
namespace {

/// Matches by coordinate, for SIMD: the model's point, then the scene's.
struct MatchTable {
  std::vector<float> mx, my, mz, sx, sy, sz;

  MatchTable(std::span<const cv::Point3f> model, std::span<const cv::Point3f> scene,
             std::span<const Match> matches) {
    for (auto* list : {&mx, &my, &mz, &sx, &sy, &sz}) list->reserve(matches.size());
    for (const Match& m : matches) {
      const cv::Point3f &a = model[m.model], &b = scene[m.scene];
      mx.push_back(a.x), my.push_back(a.y), mz.push_back(a.z);
      sx.push_back(b.x), sy.push_back(b.y), sz.push_back(b.z);
    }
  }
};

/// The difference of the distances to match i in model and scene, for each match.
ESTANCIA_MULTIVERSION void stretches(const MatchTable& t, std::size_t i, float* __restrict out) {
  const float ax = t.mx[i], ay = t.my[i], az = t.mz[i], bx = t.sx[i], by = t.sy[i], bz = t.sz[i];
  const float *mx = t.mx.data(), *my = t.my.data(), *mz = t.mz.data();
  const float *sx = t.sx.data(), *sy = t.sy.data(), *sz = t.sz.data();
  const std::size_t n = t.mx.size();
#pragma omp simd
  for (std::size_t j = 0; j < n; ++j) {
    const float dx = mx[j] - ax, dy = my[j] - ay, dz = mz[j] - az;
    const float ex = sx[j] - bx, ey = sy[j] - by, ez = sz[j] - bz;
    out[j] = std::abs(std::sqrt(dx * dx + dy * dy + dz * dz) - std::sqrt(ex * ex + ey * ey + ez * ez));
  }
}

bool keepsDistance(const MatchTable& t, std::size_t i, std::size_t j, float tolerance) {
  const float dx = t.mx[j] - t.mx[i], dy = t.my[j] - t.my[i], dz = t.mz[j] - t.mz[i];
  const float ex = t.sx[j] - t.sx[i], ey = t.sy[j] - t.sy[i], ez = t.sz[j] - t.sz[i];
  return std::abs(std::sqrt(dx * dx + dy * dy + dz * dz) - std::sqrt(ex * ex + ey * ey + ez * ez)) <=
         tolerance;
}

cv::Affine3d leastSquares(std::span<const cv::Point3f> from, std::span<const cv::Point3f> to,
                          std::span<const std::uint32_t> which) {
  Eigen::Matrix3Xd a(3, which.size()), b(3, which.size());
  for (std::size_t i = 0; i < which.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    a.col(column) << from[which[i]].x, from[which[i]].y, from[which[i]].z;
    b.col(column) << to[which[i]].x, to[which[i]].y, to[which[i]].z;
  }
  const Eigen::Matrix4d t = Eigen::umeyama(a, b, false);
  cv::Matx44d matrix;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) matrix(r, c) = t(r, c);
  return {matrix};
}

std::vector<std::uint32_t> inliersOf(const cv::Affine3d& pose, std::span<const cv::Point3f> from,
                                     std::span<const cv::Point3f> to, double tolerance) {
  std::vector<std::uint32_t> inliers;
  for (std::uint32_t i = 0; i < from.size(); ++i)
    if (cv::norm(pose * cv::Point3d(from[i]) - cv::Point3d(to[i])) <= tolerance) inliers.push_back(i);
  return inliers;
}

/// 3-D Hough voting (Tombari and Di Stefano 2010): each match votes, by the local frames of its two
/// keypoints, for the center of the model; sets are the votes within `tolerance` [m] of the vote with most
/// votes around it.
std::vector<std::vector<std::uint32_t>> houghSets(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                                  std::span<const Match> matches, double tolerance,
                                                  std::size_t minimum, int threads) {
  cv::Point3f middle;
  for (const cv::Point3f& p : model.points) middle += p * (1 / static_cast<float>(model.points.size()));
  std::vector<cv::Point3f> votes;
  votes.reserve(matches.size());
  for (const Match& m : matches) {
    const cv::Matx31f local =
        model.frames[m.model] * cv::Matx31f(cv::Vec3f(middle - model.points[m.model]).val);
    const cv::Matx31f offset = scene.frames[m.scene].t() * local;
    votes.push_back(scene.points[m.scene] + cv::Point3f(offset(0), offset(1), offset(2)));
  }
  const Neighbors neighbors(votes, threads);
  std::vector<std::vector<std::uint32_t>> around(votes.size());
  neighbors.eachWithin(static_cast<float>(tolerance), threads,
                       [&](std::uint32_t i, std::span<const Neighbor> near) {
                         if (near.size() < minimum) return;
                         for (const Neighbor& n : near) around[i].push_back(n.index);
                         std::sort(around[i].begin(), around[i].end());
                       });
  std::vector<std::uint32_t> order(votes.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return around[a].size() > around[b].size(); });
  std::vector<std::vector<std::uint32_t>> sets;
  std::vector<char> taken(votes.size(), 0);
  for (const std::uint32_t i : order) {
    if (taken[i]) continue;
    std::vector<std::uint32_t> set;
    for (const std::uint32_t j : around[i])
      if (!taken[j]) set.push_back(j);
    if (set.size() < minimum) continue;
    for (const std::uint32_t j : set) taken[j] = 1;
    sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace

Choices groupingMethods() {
  return {{"geometric-consistency", "matches that preserve their distances"},
          {"hough", "matches whose local frames vote for the same center"}};
}

std::vector<std::vector<std::uint32_t>> consistentSets(std::span<const cv::Point3f> model,
                                                       std::span<const cv::Point3f> scene,
                                                       std::span<const Match> matches, double tolerance,
                                                       std::size_t minimum, int threads) {
  constexpr std::size_t together = 64;  // seeds whose partners are looked up at once
  const MatchTable table(model, scene, matches);
  const auto limit = static_cast<float>(tolerance);
  std::vector<std::vector<std::uint32_t>> sets;
  std::vector<char> taken(matches.size(), 0);
  for (std::size_t begin = 0; begin < matches.size(); begin += together) {
    const std::size_t count = std::min(together, matches.size() - begin);
    std::vector<std::vector<std::uint32_t>> partners(count);
    inParallel(count, threads, Progress::none(), "stopped while matches were grouped", [&](std::size_t k) {
      const std::size_t i = begin + k;
      if (taken[i]) return;
      std::vector<float> stretch(matches.size());
      stretches(table, i, stretch.data());
      for (std::uint32_t j = 0; j < matches.size(); ++j)
        if (stretch[j] <= limit && j != i && !taken[j]) partners[k].push_back(j);
    });
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = begin + k;
      if (taken[i] || partners[k].size() + 1 < minimum) continue;
      std::vector<std::uint32_t> set{static_cast<std::uint32_t>(i)};
      for (const std::uint32_t j : partners[k])
        if (!taken[j] && std::all_of(set.begin() + 1, set.end(),
                                     [&](std::uint32_t s) { return keepsDistance(table, s, j, limit); }))
          set.push_back(j);
      if (set.size() < minimum) continue;
      for (const std::uint32_t j : set) taken[j] = 1;
      sets.push_back(std::move(set));
    }
  }
  return sets;
}

std::pair<cv::Affine3d, std::vector<std::uint32_t>> agreedTransform(std::span<const cv::Point3f> from,
                                                                    std::span<const cv::Point3f> to,
                                                                    double tolerance) {
  constexpr int samples = 200;
  constexpr std::size_t minInliers = 3;
  cv::Affine3d best;
  std::vector<std::uint32_t> inliers;
  if (from.size() < minInliers) return {best, inliers};
  const auto consider = [&](std::span<const std::uint32_t> sample) {
    const cv::Affine3d pose = leastSquares(from, to, sample);
    auto agree = inliersOf(pose, from, to, tolerance);
    if (agree.size() <= inliers.size()) return;
    best = pose;
    inliers = std::move(agree);
  };
  std::vector<std::uint32_t> all(from.size());
  std::iota(all.begin(), all.end(), 0U);
  consider(all);
  std::minstd_rand random(1);  // a fixed seed: the same matches give the same pose
  for (int s = 0; s < samples && inliers.size() < from.size(); ++s) {
    std::uint32_t sample[3];
    for (std::uint32_t& index : sample) index = static_cast<std::uint32_t>(random() % from.size());
    if (sample[0] != sample[1] && sample[1] != sample[2] && sample[2] != sample[0]) consider(sample);
  }
  if (inliers.size() < minInliers) return {best, {}};
  for (int round = 0; round < 2; ++round) {
    const cv::Affine3d pose = leastSquares(from, to, inliers);
    auto agree = inliersOf(pose, from, to, tolerance);
    if (agree.size() < inliers.size()) break;
    best = pose;
    inliers = std::move(agree);
  }
  return {best, inliers};
}

std::vector<Hypothesis> groupMatches(const SurfaceFeatures& model, const SurfaceFeatures& scene,
                                     const std::vector<Match>& matches, const std::string& method,
                                     double tolerance, std::size_t minimum, int threads) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    fail(ErrorCode::invalidOption, "the tolerance of grouping is {} m; give a positive one", tolerance);
  requireChoice("grouping", method, groupingMethods());
  const auto sets = method == "hough"
                        ? houghSets(model, scene, matches, tolerance, minimum, threads)
                        : consistentSets(model.points, scene.points, matches, tolerance, minimum, threads);
  std::vector<Hypothesis> hypotheses(sets.size());
  inParallel(sets.size(), threads, Progress::none(), "stopped while matches were grouped",
             [&](std::size_t s) {
               std::vector<cv::Point3f> from, to;
               for (const std::uint32_t i : sets[s]) {
                 from.push_back(model.points[matches[i].model]);
                 to.push_back(scene.points[matches[i].scene]);
               }
               const auto [pose, inliers] = agreedTransform(from, to, tolerance);
               hypotheses[s].pose = pose;
               for (const std::uint32_t i : inliers) hypotheses[s].matches.push_back(matches[sets[s][i]]);
             });
  std::erase_if(hypotheses,
                [&](const Hypothesis& h) { return h.matches.size() < std::max<std::size_t>(minimum, 3); });
  std::stable_sort(hypotheses.begin(), hypotheses.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.matches.size() > b.matches.size();
  });
  return hypotheses;
}

}  // namespace estancia
