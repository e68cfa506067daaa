// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/pose_score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/cloud/neighbors.hpp"

namespace estancia {
namespace {

constexpr float grazing = 0.15F;  // cosine below which a sensor measures nothing of a surface

/// cv's operators have loops that are not unrolled.
inline cv::Point3f moved(const cv::Matx33f& m, const cv::Point3f& p) {
  return {m.val[0] * p.x + m.val[1] * p.y + m.val[2] * p.z, m.val[3] * p.x + m.val[4] * p.y + m.val[5] * p.z,
          m.val[6] * p.x + m.val[7] * p.y + m.val[8] * p.z};
}

/// Whether it could be visible to a sensor at the origin.
inline bool faces(const cv::Point3f& p, const cv::Point3f& n) {
  const float along = n.dot(p);
  return along <= 0 && along * along >= grazing * grazing * p.dot(p);
}

/// Difference of two colors in CIELAB; lightness counts half.
float colorDifference(const cv::Vec3f& a, const cv::Vec3f& b) {
  const cv::Vec3f d = a - b;
  return std::sqrt(d[0] * d[0] / 4 + d[1] * d[1] + d[2] * d[2]);
}

/// The weights of all points, and of some kinds: PoseScore.
struct PointWeights {
  float total = 0, facing = 0, supported = 0, seenThrough = 0, occluded = 0, mismatched = 0, behind = 0,
        support = 0;
  std::size_t points = 0;

  PoseScore shares() const {
    if (!(total > 0)) return {};
    return {.facing = facing / total,
            .supported = supported / total,
            .seenThrough = seenThrough / total,
            .occluded = occluded / total,
            .mismatched = mismatched / total,
            .behind = behind / total,
            .support = support / total,
            .points = points};
  }
};

}  // namespace

PoseScore scorePose(const OrientedPoints& model, const DenseScene& scene, const cv::Affine3d& pose,
                    const PoseTolerances& limits, PosePoints* list) {
  const cv::Matx33f turn(pose.rotation());
  const cv::Point3f shift(cv::Vec3f(pose.translation()));
  const auto offset = static_cast<float>(limits.offset), freeSpace = static_cast<float>(limits.freeSpace),
             minDot = static_cast<float>(limits.minDot);
  const float perOffset = 1 / (offset * offset), perAngle = 1 / (1 - minDot);
  const bool seen = scene.view.known();
  const bool colored = limits.color > 0 && !model.lab.empty() && !scene.surface.lab().empty();
  PointWeights sum;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3f p = moved(turn, model.points[i]) + shift, n = moved(turn, model.normals[i]);
    const float w = model.weights.empty() ? 1 : model.weights[i];
    sum.total += w;
    if (seen && !faces(p, n)) {
      const auto depths = scene.view.depthsAround(p);
      if (depths && depths->nearest > p.z + freeSpace) sum.behind += w;
      continue;
    }
    sum.facing += w;
    if (list != nullptr && scene.measured != nullptr) {
      const auto depths = scene.measured->depthsAround(p);
      if (depths && depths->nearest > p.z + freeSpace) {
        sum.seenThrough += w;
        continue;
      }
    }
    const std::int32_t near = scene.field.at(p);
    if (near != NearestField::none) {
      const auto k = static_cast<std::size_t>(near);
      const cv::Point3f& m = scene.surface.normals()[k];
      const float off = std::abs(m.dot(p - scene.surface.points()[k])), dot = cosineOf(m, n, seen);
      if (off < offset && dot > minDot &&
          !(colored && colorDifference(model.lab[i], scene.surface.lab()[k]) > limits.color)) {
        ++sum.points;
        sum.supported += w;
        const float weight = w * (1 - off * off * perOffset) * (1 - (1 - dot) * perAngle);
        sum.support += weight;
        if (list != nullptr) list->supported.push_back({static_cast<std::uint32_t>(k), weight});
        continue;
      }
      if (!seen) sum.mismatched += w;
    }
    if (!seen) continue;
    const auto depths = scene.view.depthsAround(p);
    if (!depths) continue;
    if (depths->nearest > p.z + freeSpace) {
      sum.seenThrough += w;
    } else if (depths->farthest < p.z - freeSpace) {
      sum.occluded += w;
      if (list != nullptr) list->hidden.push_back({p, w});
    } else {
      sum.mismatched += w;
    }
  }
  return sum.shares();
}

namespace {

/// Least squares of the color differences to the neighbors over their tangential offsets.
cv::Matx33f gradientAt(const Surface& surface, std::uint32_t i, std::span<const Neighbor> near) {
  const cv::Point3f &p = surface.points()[i], &n = surface.normals()[i];
  Eigen::Matrix3d offsets = Eigen::Matrix3d::Zero(), products = Eigen::Matrix3d::Zero();
  for (const Neighbor& neighbor : near) {
    cv::Point3f d = surface.points()[neighbor.index] - p;
    d -= n.dot(d) * n;
    const cv::Vec3f change = surface.lab()[neighbor.index] - surface.lab()[i];
    const Eigen::Vector3d offset(d.x, d.y, d.z);
    offsets += offset * offset.transpose();
    products += Eigen::Vector3d(change[0], change[1], change[2]) * offset.transpose();
  }
  // The gradient has no part along the normal, which the offsets leave open.
  const Eigen::Vector3d normal(n.x, n.y, n.z);
  const double scale = offsets.trace();
  if (!(scale > 0)) return cv::Matx33f::zeros();
  const Eigen::Matrix3d closed =
      offsets + scale * normal * normal.transpose() + 1e-6 * scale * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d gradient = closed.ldlt().solve(products.transpose()).transpose();
  cv::Matx33f rows;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rows(r, c) = static_cast<float>(gradient(r, c));
  return rows;
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// The rows of colored ICP beside those of the planes (Park, Zhou, Koltun 2017, equation 13): the color of a
/// model point should be that of the scene's surface where it lies. Differences that all points share, of
/// light and exposure, do not count: they are taken from the round before, so the first round has no rows.
class ColorTerm {
 public:
  /// A difference of `tolerance` weighs as much as a distance of the reach. Off when it is 0, or model or
  /// scene has no colors.
  ColorTerm(const std::vector<cv::Vec3f>& model, const DenseScene& scene, double tolerance)
      : model_(model),
        scene_(scene),
        tolerance_(model.empty() || scene.gradients == nullptr || scene.gradients->empty() ? 0 : tolerance) {}

  bool on() const { return tolerance_ > 0; }

  /// A partner: the i-th point of the model at `p`, near the k-th of the scene; lever arms are relative to
  /// `middle` and divided by `size` [m].
  void add(std::size_t i, std::size_t k, const cv::Point3f& p, const cv::Point3f& middle, double size,
           double weight, double reach, Matrix6& left, Vector6& right) {
    if (!on()) return;
    const Surface& surface = scene_.surface;
    const cv::Matx33f& gradient = (*scene_.gradients)[k];
    const cv::Point3f &q = surface.points()[k], &n = surface.normals()[k];
    cv::Point3f offset = p - q;
    offset -= n.dot(offset) * n;
    const cv::Vec3f there = surface.lab()[k] + gradient * cv::Vec3f(offset.x, offset.y, offset.z);
    const cv::Vec3d difference = cv::Vec3d(model_[i]) - cv::Vec3d(there);
    sum_ += weight * difference;
    weights_ += weight;
    if (first_) return;
    const double scaled = weight * reach * reach / (tolerance_ * tolerance_);
    for (int c = 0; c < 3; ++c) {
      const cv::Point3f slope(gradient(c, 0), gradient(c, 1), gradient(c, 2));
      const cv::Point3f lever = (p - middle).cross(slope);
      const double channel = c == 0 ? scaled / 4 : scaled;  // weighted as in colorDifference()
      Vector6 row;
      row << lever.x / size, lever.y / size, lever.z / size, slope.x, slope.y, slope.z;
      left.noalias() += channel * row * row.transpose();
      right.noalias() += channel * (difference[c] - shared_[c]) * row;
    }
  }

  void endRound() {
    if (weights_ > 0) shared_ = sum_ / weights_;
    sum_ = {};
    weights_ = 0;
    first_ = false;
  }

 private:
  const std::vector<cv::Vec3f>& model_;
  const DenseScene& scene_;
  double tolerance_;
  bool first_ = true;
  cv::Vec3d shared_, sum_;
  double weights_ = 0;
};

std::vector<PoseHypothesis> bestOf(std::vector<PoseHypothesis> poses, const cv::Point3d& center,
                                   double minDistance, std::size_t max) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.evidence > b.evidence; });
  return distinctPoses(std::move(poses), center, minDistance, std::cos(0.15), max);  // [rad]
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
  const double facing = closed ? std::clamp(score.facing, 0.25, 1.0) : 1;
  return score.vote() / facing * std::sqrt(facing * points / 700);
}

}  // namespace

std::vector<cv::Matx33f> colorGradients(const Surface& surface, double radius, int threads) {
  std::vector<cv::Matx33f> gradients;
  if (surface.lab().empty()) return gradients;
  gradients.resize(surface.size());
  surface.neighbors().eachWithin(
      static_cast<float>(radius), threads,
      [&](std::uint32_t i, std::span<const Neighbor> near) { gradients[i] = gradientAt(surface, i, near); });
  return gradients;
}

void balanceNormals(OrientedPoints& model) {
  constexpr float similar = 0.94F;  // cosine of 20°
  model.weights.assign(model.points.size(), 1);
  double sum = 0;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const auto same = std::count_if(model.normals.begin(), model.normals.end(),
                                    [&](const cv::Point3f& n) { return n.dot(model.normals[i]) > similar; });
    model.weights[i] = static_cast<float>(std::pow(std::max<double>(1, static_cast<double>(same)), -0.5));
    sum += static_cast<double>(model.weights[i]);
  }
  for (float& w : model.weights) w = static_cast<float>(w * static_cast<double>(model.points.size()) / sum);
}

cv::Affine3d refineInField(const OrientedPoints& model, const cv::Point3d& center, const DenseScene& scene,
                           const cv::Affine3d& pose, const FieldRefinement& options) {
  constexpr float minDot = 0.5F;          // cosine of normals that can be of the same surface
  constexpr double maxRotation = 0.3;     // [rad] a round
  constexpr double stillRotation = 2e-4;  // [rad]
  const bool seen = scene.view.known();
  cv::Affine3d refined = pose;
  ColorTerm color(model.lab, scene, options.color);
  double size = 0;
  for (const cv::Point3f& p : model.points) size = std::max(size, cv::norm(cv::Point3d(p) - center));
  for (int round = 0; round < options.rounds; ++round) {
    const auto reach = static_cast<float>(options.firstReach + (options.lastReach - options.firstReach) *
                                                                   round / std::max(1, options.rounds - 1));
    const cv::Affine3f transform(refined);
    const cv::Matx33f turn = transform.rotation();
    const cv::Point3f middle = transform * cv::Point3f(center);
    Matrix6 left = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    int partners = 0;
    for (std::size_t i = 0; i < model.points.size(); ++i) {
      const cv::Point3f p = transform * model.points[i], n = turn * model.normals[i];
      if (seen && !faces(p, n)) continue;
      const std::int32_t near = scene.field.at(p);
      if (near == NearestField::none) continue;
      const auto k = static_cast<std::size_t>(near);
      const cv::Point3f& m = scene.surface.normals()[k];
      if (cosineOf(m, n, seen) < minDot) continue;
      const float off = m.dot(scene.surface.points()[k] - p);
      if (std::abs(off) > reach) continue;
      const double weight = 1 - static_cast<double>(off * off / (reach * reach));
      const cv::Point3f lever = (p - middle).cross(m);
      Vector6 row;
      row << lever.x / size, lever.y / size, lever.z / size, m.x, m.y, m.z;
      left.noalias() += weight * row * row.transpose();
      right.noalias() += weight * static_cast<double>(off) * row;
      color.add(i, k, p, middle, size, weight, static_cast<double>(reach), left, right);
      ++partners;
    }
    color.endRound();
    if (partners < 12) return refined;
    // Damping: planes and spheres do not fix all directions.
    left.diagonal().array() += 1e-5 * left.diagonal().maxCoeff();
    const Vector6 x = left.ldlt().solve(right);
    if (!x.allFinite()) return refined;
    cv::Vec3d rotation(x[0] / size, x[1] / size, x[2] / size);
    const cv::Vec3d shift(x[3], x[4], x[5]);
    const double angle = cv::norm(rotation);
    if (angle > maxRotation) rotation *= maxRotation / angle;
    const cv::Affine3d by(rotation);
    const cv::Vec3d at(refined * center);
    // p → R (p − center) + center + shift
    refined = cv::Affine3d(by.rotation(), at - by.rotation() * at + shift) * refined;
    if (round == 0 && color.on()) continue;  // color is not used before the second round
    if (angle < stillRotation && cv::norm(shift) < stillRotation * size / 5) break;
  }
  return refined;
}

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
  // A model that is small or far away has more points than were measured on it.
  const auto measuredOn = [&](const cv::Affine3d& pose) {
    const double away = dense.view.known() ? (pose * points.center).z / dense.view.medianDepth() : 1;
    return std::pow(std::min(1.0, unit / std::max(scales.spacing * away, unit)), 2);
  };
  each(poses.size(), 4, threads, [&](std::size_t i) {
    PoseHypothesis& p = poses[i];
    p.pose = refineInField(points.coarse, points.center, dense, p.pose, {10 * unit, 6 * unit, 10, color});
    p.score = scoreOutlined(points.coarse, points.extent, dense, p.pose,
                            {4 * unit, 7.5 * unit + noise, 0.65, color});
    p.evidence = p.score.vote();
  });
  poses = bestOf(std::move(poses), points.center, 5 * unit, maxFine);
  each(poses.size(), 1, threads, [&](std::size_t i) {
    PoseHypothesis& p = poses[i];
    p.pose = refineInField(points.fine, points.center, dense, p.pose,
                           {7.5 * unit, 3 * unit + 0.2 * noise, 15, color});
    p.score = scoreOutlined(points.fine, points.extent, dense, p.pose, toleranceOf(scales));
    p.evidence = evidenceFor(p.score, measuredOn(p.pose) * static_cast<double>(points.area),
                             points.closed && dense.view.known());
  });
  return bestOf(std::move(poses), points.center, 5 * unit, maxFine);
}

}  // namespace estancia
