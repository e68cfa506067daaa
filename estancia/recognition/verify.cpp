// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/verify.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_map>

namespace estancia {
namespace {

// λ and κ of the paper, chosen on three scenes of shot_kinect (its own 3 and 5 lose objects there).
constexpr double outlierWeight = 1;  // weight of a model point without a scene point near it
constexpr float clutterWeight = 3;   // weight of an unexplained point of the same smooth part

struct Weighed {
  std::uint32_t point;  ///< point of the scene
  float weight;
};

/// The cues of one hypothesis (section 3.2 of the paper).
struct Cues {
  std::vector<Weighed> explained, unexplained;
  double outliers = 0;
};

Cues cuesOf(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
            std::span<const int> parts, const cv::Affine3d& pose, double tolerance) {
  const cv::Affine3f transform(pose);
  const cv::Matx33f rotation = transform.rotation();
  const auto reach = static_cast<float>(tolerance);
  const auto around = static_cast<float>(2 * tolerance);  // in which unexplained points are clutter
  Cues cues;
  std::vector<Neighbor> buffer;
  struct Partner {
    float squared, cosine;
  };
  std::unordered_map<std::uint32_t, Partner> explained;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3f p = transform * model.points[i], n = rotation * model.normals[i];
    if (view.known()) {  // invisible points explain nothing and are no outliers
      const auto depth = view.depth(p);
      if (n.dot(p) > 0 || !depth || *depth < p.z - 2 * reach) continue;
    }
    const auto near = scene.neighbors().within(p, reach, buffer);
    if (near.empty()) cues.outliers += 1;
    for (const Neighbor& s : near) {
      const Partner partner{s.squared, n.dot(scene.normals()[s.index])};
      const auto [at, fresh] = explained.emplace(s.index, partner);
      if (!fresh && partner.squared < at->second.squared) at->second = partner;
    }
  }
  for (const auto& [point, partner] : explained)
    cues.explained.push_back(
        {point, (1 - partner.squared / (reach * reach)) * std::clamp(partner.cosine, 0.F, 1.F)});
  const auto byPoint = [](const Weighed& a, const Weighed& b) { return a.point < b.point; };
  std::sort(cues.explained.begin(), cues.explained.end(), byPoint);

  std::unordered_map<std::uint32_t, float> unexplained;
  for (const Weighed& e : cues.explained)
    for (const Neighbor& s : scene.neighbors().within(scene.points()[e.point], around, buffer)) {
      if (explained.contains(s.index)) continue;
      const bool samePart = parts[s.index] != 0 && parts[s.index] == parts[e.point];
      const float alike = std::clamp(scene.normals()[s.index].dot(scene.normals()[e.point]), 0.F, 1.F);
      const float weight = (1 - s.squared / (around * around)) * (samePart ? clutterWeight : alike);
      float& largest = unexplained[s.index];
      largest = std::max(largest, weight);
    }
  for (const auto& [point, weight] : unexplained) cues.unexplained.push_back({point, weight});
  std::sort(cues.unexplained.begin(), cues.unexplained.end(), byPoint);
  return cues;
}

/// The cost of a set of hypotheses, updated while they are added and removed.
class Cost {
 public:
  Cost(std::size_t points, std::span<const Cues> cues)
      : cues_(cues), active_(cues.size(), false), explained_(points), weight_(points), unexplained_(points) {}

  double value() const { return value_; }
  const std::vector<bool>& active() const { return active_; }

  void flip(std::size_t h) {
    active_[h] = !active_[h];
    const int sign = active_[h] ? 1 : -1;
    const auto change = [&](std::uint32_t p, auto&& what) {
      value_ -= costOf(p);
      what();
      value_ += costOf(p);
    };
    for (const auto& [point, weight] : cues_[h].explained)
      change(point, [&, p = point, w = weight] {
        explained_[p] += sign, weight_[p] += sign * static_cast<double>(w);
      });
    for (const auto& [point, weight] : cues_[h].unexplained)
      change(point, [&, p = point, w = weight] { unexplained_[p] += sign * static_cast<double>(w); });
    value_ += sign * (outlierWeight * cues_[h].outliers + 1);
  }

 private:
  /// The cost of a scene point: less when explained, more when explained twice or unexplained.
  double costOf(std::uint32_t p) const {
    if (explained_[p] == 0) return unexplained_[p];
    return (explained_[p] > 1 ? explained_[p] : 0) - weight_[p];
  }

  std::span<const Cues> cues_;
  double value_ = 0;
  std::vector<bool> active_;
  std::vector<int> explained_;
  std::vector<double> weight_, unexplained_;
};

constexpr double minPartnerDot = 0.5;  // cosine of normals that can be of the same surface
constexpr std::size_t minPartners = 10;

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// The normal equations of one round: rotation around `center`, the model's center in the scene, then
/// translation.
struct Equations {
  Eigen::Matrix<double, 6, 6> left = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6 right = Vector6::Zero();
  std::size_t partners = 0;
};

Equations equationsOf(const OrientedPoints& model, const Surface& scene, const cv::Affine3d& pose,
                      const cv::Vec3d& center, double reach) {
  Equations sum;
  std::vector<Neighbor> buffer;
  const double reach2 = reach * reach;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3d p = pose * cv::Point3d(model.points[i]);
    const auto near = scene.neighbors().nearest(cv::Point3f(p), 1, buffer, static_cast<float>(reach));
    if (near.empty()) continue;
    const cv::Vec3d n(cv::Point3d(scene.normals()[near[0].index]));
    const cv::Vec3d m = pose.rotation() * cv::Vec3d(cv::Point3d(model.normals[i]));
    if (n.dot(m) < minPartnerDot) continue;
    const double shrink = 1 - static_cast<double>(near[0].squared) / reach2;
    const double weight = shrink * shrink;
    const cv::Vec3d q(cv::Point3d(scene.points()[near[0].index])), at(p);
    const cv::Vec3d turn = (at - center).cross(n);
    Vector6 row;
    row << turn[0], turn[1], turn[2], n[0], n[1], n[2];
    sum.left += weight * row * row.transpose();
    sum.right += weight * n.dot(q - at) * row;
    ++sum.partners;
  }
  return sum;
}

}  // namespace

double InlierCounts::confidence() const {
  if (inliers == 0) return 0;
  const auto count = static_cast<double>(inliers);
  return count / static_cast<double>(facing - occluded) * std::sqrt(count / static_cast<double>(facing));
}

InlierCounts countInliers(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                          const cv::Affine3d& pose, double tolerance) {
  constexpr float minDot = 0.7F;   // cosine of normals of the same surface
  constexpr float grazing = 0.1F;  // cosine below which a sensor measures nothing of a surface
  InlierCounts counts;
  counts.points = model.points.size();
  const cv::Affine3f transform(pose);
  const cv::Matx33f rotation = transform.rotation();
  const auto reach = static_cast<float>(tolerance);
  std::vector<Neighbor> buffer;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const cv::Point3f p = transform * model.points[i], n = rotation * model.normals[i];
    if (view.known() && -n.dot(p) < grazing * static_cast<float>(cv::norm(p))) continue;
    ++counts.facing;
    const auto near = scene.neighbors().nearest(p, 1, buffer, reach);
    if (!near.empty() && n.dot(scene.normals()[near[0].index]) > minDot) {
      ++counts.inliers;
      continue;
    }
    if (!view.known()) continue;
    const auto depth = view.depth(p);
    if (!depth || *depth < p.z - 2 * reach)
      ++counts.occluded;
    else if (*depth > p.z + 2 * reach)
      ++counts.seenThrough;
  }
  return counts;
}

bool isAccepted(const InlierCounts& counts, double accept) {
  return counts.inliers > 0 && counts.confidence() >= accept && 5 * counts.seenThrough <= counts.facing &&
         20 * counts.facing >= 9 * counts.points;
}

std::vector<int> smoothPartsOf(const Surface& surface, double reach, int threads) {
  constexpr float smooth = 0.98006658F;  // cos 0.2 rad
  constexpr int minPoints = 20;          // points of a part
  const auto size = static_cast<std::uint32_t>(surface.size());
  std::vector<std::vector<std::uint32_t>> links(size);
  surface.neighbors().eachWithin(
      static_cast<float>(reach), threads, [&](std::uint32_t i, std::span<const Neighbor> near) {
        for (const Neighbor& n : near)
          if (n.index != i && surface.normals()[i].dot(surface.normals()[n.index]) > smooth)
            links[i].push_back(n.index);
      });
  std::vector<int> parts(size, -1);
  int part = 0;
  std::vector<std::uint32_t> members;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (parts[i] >= 0) continue;
    ++part;
    members.assign(1, i);
    parts[i] = part;
    for (std::size_t m = 0; m < members.size(); ++m)
      for (const std::uint32_t j : links[members[m]])
        if (parts[j] < 0) {
          parts[j] = part;
          members.push_back(j);
        }
    if (members.size() < minPoints)
      for (const std::uint32_t j : members) parts[j] = 0;
  }
  return parts;
}

std::vector<bool> verifyGlobally(const OrientedPoints& model, const Surface& scene, const RangeImage& view,
                                 std::span<const int> smoothParts, std::span<const cv::Affine3d> poses,
                                 double tolerance) {
  if (poses.empty()) return {};
  std::vector<Cues> cues;
  for (const cv::Affine3d& pose : poses)
    cues.push_back(cuesOf(model, scene, view, smoothParts, pose, tolerance));
  Cost cost(scene.size(), cues);
  std::vector<bool> best = cost.active();
  double lowest = cost.value();
  const auto keepBest = [&] {
    if (cost.value() < lowest - 1e-9) lowest = cost.value(), best = cost.active();
  };
  std::mt19937_64 random(1);
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const std::size_t moves = 100 * poses.size();
  double temperature = static_cast<double>(model.points.size()) / 4;
  const double cooling = std::pow(1e-3, 1 / static_cast<double>(moves));
  for (std::size_t move = 0; move < moves; ++move, temperature *= cooling) {
    const std::size_t h = random() % poses.size();
    const double before = cost.value();
    cost.flip(h);
    if (cost.value() > before && uniform() > std::exp((before - cost.value()) / temperature)) cost.flip(h);
    keepBest();
  }
  // Greedy descent from the best set.
  for (std::size_t h = 0; h < poses.size(); ++h)
    if (cost.active()[h] != best[h]) cost.flip(h);
  for (bool better = true; better;) {
    better = false;
    for (std::size_t h = 0; h < poses.size(); ++h) {
      const double before = cost.value();
      cost.flip(h);
      if (cost.value() < before - 1e-6)
        better = true;
      else
        cost.flip(h);
    }
  }
  keepBest();
  return best;
}

cv::Affine3d refinePose(const OrientedPoints& model, const Surface& scene, const cv::Affine3d& pose,
                        double reach, int rounds) {
  cv::Point3d middle;
  for (const cv::Point3f& p : model.points)
    middle += cv::Point3d(p) / static_cast<double>(model.points.size());
  double size = 0;
  for (const cv::Point3f& p : model.points) size = std::max(size, cv::norm(cv::Point3d(p) - middle));
  cv::Affine3d refined = pose;
  for (int round = 0; round < rounds; ++round) {
    const cv::Vec3d center(refined * middle);
    Equations e = equationsOf(model, scene, refined, center, reach);
    if (e.partners < minPartners) return round == 0 ? pose : refined;
    // Damping: planes and spheres do not fix all directions; in those the pose stays.
    for (int k = 0; k < 6; ++k)
      e.left(k, k) += 1e-6 * static_cast<double>(e.partners) * (k < 3 ? size * size : 1);
    const Vector6 x = e.left.ldlt().solve(e.right);
    if (!x.allFinite()) return refined;
    const cv::Affine3d turn(cv::Vec3d(x[0], x[1], x[2]));
    const cv::Vec3d shift(x[3], x[4], x[5]);
    // p → R (p − center) + center + shift
    refined = cv::Affine3d(turn.rotation(), center - turn.rotation() * center + shift) * refined;
    if (x.head<3>().norm() * size + x.tail<3>().norm() < 1e-3 * reach) break;
  }
  return refined;
}

}  // namespace estancia
