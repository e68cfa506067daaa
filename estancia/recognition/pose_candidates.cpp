// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/pose_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

constexpr double usual = 0.13;                             // evidence of wrong poses, at least
constexpr double unitChance = 0.15;                        // chance at which the scale is tailDecay
constexpr double tailOffset = 0.0135, tailDecay = 0.0195;  // parameters of the tail, measured

/// The evidence of the poses that are `apart` from the first `count` places.
std::vector<double> elsewhere(const std::vector<PoseHypothesis>& poses,
                              const std::vector<PoseHypothesis>& places, std::size_t count,
                              const cv::Point3d& center, double apart) {
  std::vector<double> evidence;
  for (const PoseHypothesis& pose : poses)
    if (std::none_of(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count),
                     [&](const PoseHypothesis& place) {
                       return cv::norm(pose.pose * center - place.pose * center) < apart;
                     }))
      evidence.push_back(pose.evidence);
  return evidence;
}

/// An instance that is accepted on its own.
struct Item {
  std::size_t candidates, instance;
  const PoseCandidates* of;
  const PoseHypothesis* pose;
  double threshold = 0;              // evidence
  double support = 0;                // the evidence of its supported points alone
  std::vector<PointSupport> points;  // their shares of that

  double surplus() const { return (pose->evidence - threshold) / of->falseAlarms.evidenceScale(); }
};

std::vector<Item> itemsOf(const std::vector<PoseCandidates>& candidates, double rate) {
  std::vector<Item> items;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const PoseCandidates& of = candidates[c];
    for (std::size_t i = 0; i < of.instances.size(); ++i) {
      const PoseHypothesis& pose = of.instances[i];
      // vote() is the support less what speaks against the pose; evidence is proportional to it.
      const double vote = pose.score.vote();
      std::vector<PointSupport> points;
      const DenseModel& model = of.modelSurface->dense;
      scoreOutlined(model.fine, model.extent, of.sceneSurface->dense(), pose.pose,
                    toleranceOf(of.sceneSurface->scales), &points);
      items.push_back({c, i, &of, &pose, of.falseAlarms.evidenceOf(rate),
                       vote > 0 ? pose.evidence * pose.score.support / vote : 0, std::move(points)});
    }
  }
  std::ranges::stable_sort(items, std::ranges::greater(),
                           [](const Item& i) { return std::pair(i.surplus() >= 0, i.pose->evidence); });
  return items;
}

/// Whether a surface point [m] with this normal lies on the model of an instance. More generous than support:
/// two surfaces cannot be so near to each other.
bool explains(const Item& item, const cv::Affine3f& fromScene, const cv::Point3f& point,
              const cv::Point3f& normal) {
  constexpr float across = 2, along = 3;  // tolerances
  constexpr float minDot = 0.5F;
  const PreparedModel::Described& model = *item.of->modelSurface;
  const auto tolerance = static_cast<float>(item.of->sceneSurface->scales.tolerance);
  const cv::Point3f p = fromScene * point;
  const std::int32_t near = model.field.at(p);
  if (near == NearestField::none) return false;
  const auto k = static_cast<std::size_t>(near);
  const cv::Point3f off = p - model.surface->points()[k], &n = model.surface->normals()[k];
  return std::abs(n.dot(off)) < across * tolerance && off.dot(off) < along * along * tolerance * tolerance &&
         cosineOf(n, fromScene.rotation() * normal, item.of->sceneSurface->view.known()) > minDot;
}

/// For each supported point of an instance whether the other explains it.
std::vector<bool> explainedBy(const Item& item, const Item& other) {
  const Surface& scene = *item.of->sceneSurface->surface;
  const cv::Affine3f fromScene(other.pose->pose.inv());
  std::vector<bool> explained(item.points.size());
  for (std::size_t i = 0; i < item.points.size(); ++i)
    explained[i] = explains(other, fromScene, scene.points()[item.points[i].scenePoint],
                            scene.normals()[item.points[i].scenePoint]);
  return explained;
}

double weightOf(const Item& item, const std::vector<bool>& which) {
  double sum = 0, all = 0;
  for (std::size_t i = 0; i < item.points.size(); ++i) {
    const auto weight = static_cast<double>(item.points[i].weight);
    all += weight;
    if (which[i]) sum += weight;
  }
  return all > 0 ? sum / all : 0;
}

/// Depth first over the items of one component; the bound is what the remaining gains could add.
class BranchAndBound {
 public:
  BranchAndBound(const std::vector<double>& gains, const std::vector<double>& losses,
                 std::vector<std::size_t> items)
      : gains_(gains), losses_(losses), items_(std::move(items)), rest_(items_.size() + 1, 0) {
    for (std::size_t i = items_.size(); i > 0; --i)
      rest_[i - 1] = rest_[i] + std::max(0.0, gains_[items_[i - 1]]);
  }
  std::vector<std::size_t> best() {
    visit(0, 0);
    return best_;
  }

 private:
  void visit(std::size_t at, double value) {
    if (value > most_) {
      most_ = value;
      best_ = chosen_;
    }
    if (at == items_.size() || value + rest_[at] <= most_) return;
    double gain = gains_[items_[at]];
    for (const std::size_t other : chosen_) gain -= losses_[items_[at] * gains_.size() + other];
    chosen_.push_back(items_[at]);
    visit(at + 1, value + gain);
    chosen_.pop_back();
    visit(at + 1, value);
  }

  const std::vector<double>&gains_, &losses_;
  std::vector<std::size_t> items_, chosen_, best_;
  std::vector<double> rest_;
  double most_ = 0;
};

std::vector<std::size_t> greedily(const std::vector<double>& gains, const std::vector<double>& losses,
                                  std::vector<std::size_t> items) {
  std::stable_sort(items.begin(), items.end(),
                   [&](std::size_t a, std::size_t b) { return gains[a] > gains[b]; });
  std::vector<std::size_t> chosen;
  for (const std::size_t item : items) {
    double gain = gains[item];
    for (const std::size_t other : chosen) gain -= losses[item * gains.size() + other];
    if (gain > 0) chosen.push_back(item);
  }
  return chosen;
}

/// Items that losses connect.
std::vector<std::vector<std::size_t>> componentsOf(std::size_t count, const std::vector<double>& losses) {
  std::vector<std::vector<std::size_t>> components;
  std::vector<bool> seen(count);
  for (std::size_t first = 0; first < count; ++first) {
    if (seen[first]) continue;
    std::vector<std::size_t> component{first};
    seen[first] = true;
    for (std::size_t at = 0; at < component.size(); ++at)
      for (std::size_t other = 0; other < count; ++other)
        if (!seen[other] && losses[component[at] * count + other] > 0) {
          seen[other] = true;
          component.push_back(other);
        }
    std::sort(component.begin(), component.end());
    components.push_back(std::move(component));
  }
  return components;
}

}  // namespace

FalseAlarmModel::FalseAlarmModel(std::vector<double> wrong) {
  std::sort(wrong.begin(), wrong.end(), std::greater());
  wrong.resize(wrongPoses, usual);
  chance_ = std::max(usual, std::accumulate(wrong.begin(), wrong.end(), 0.0) / wrongPoses);
  scale_ = std::sqrt(chance_ / unitChance);
}

double FalseAlarmModel::rate(double evidence) const {
  return std::min(1.0, std::exp(-((evidence - chance_) / scale_ - tailOffset) / tailDecay));
}

double FalseAlarmModel::evidenceOf(double rate) const {
  return chance_ + scale_ * (tailOffset - tailDecay * std::log(rate));
}

double FalseAlarmModel::maybe(double rate) {
  return std::min(1.0, 10 * rate);
}

double FalseAlarmModel::evidenceScale() const {
  return scale_ * tailDecay;
}

Instances instancesOf(const std::vector<PoseHypothesis>& poses, const cv::Point3d& center, double apart,
                      double rate) {
  const double standsOut = RecognitionOptions{}.falseAlarmRate;  // then it is none of the wrong poses
  Instances found;
  found.poses = distinctPoses(poses, center, apart, anyRotation);
  for (std::size_t count = found.poses.size(); count > 0; --count) {
    const FalseAlarmModel falseAlarms(elsewhere(poses, found.poses, count, center, apart));
    const bool last = falseAlarms.rate(found.poses[count - 1].evidence) <= standsOut;
    if (!last && count > 1) continue;
    found.falseAlarms = falseAlarms;
    break;
  }
  std::erase_if(found.poses,
                [&](const PoseHypothesis& p) { return found.falseAlarms.rate(p.evidence) > rate; });
  return found;
}

std::vector<std::size_t> bestSubset(const std::vector<double>& gains, const std::vector<double>& losses) {
  constexpr std::size_t maxExact = 24;
  std::vector<std::size_t> chosen;
  for (std::vector<std::size_t>& component : componentsOf(gains.size(), losses)) {
    const auto best = component.size() <= maxExact
                          ? BranchAndBound(gains, losses, std::move(component)).best()
                          : greedily(gains, losses, std::move(component));
    chosen.insert(chosen.end(), best.begin(), best.end());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

VerifiedInstances verifyTogether(const std::vector<PoseCandidates>& candidates, double rate, int threads) {
  const std::vector<Item> items = itemsOf(candidates, rate);
  const std::size_t count = items.size();
  const auto sure = static_cast<std::size_t>(
      std::ranges::count_if(items, [](const Item& item) { return item.surplus() >= 0; }));
  // For each item and each better one which of its points that explains; the worse one of a pair loses them.
  std::vector<std::vector<bool>> explained(count * count);
  std::vector<double> gains(sure), losses(sure * sure, 0);
  inParallel(count, threads, Progress::none(), "stopped while instances were compared", [&](std::size_t i) {
    if (i < sure) gains[i] = items[i].surplus();
    for (std::size_t j = 0; j < i; ++j) {
      std::vector<bool>& points = explained[i * count + j] = explainedBy(items[i], items[j]);
      if (i >= sure) continue;
      const double lost = items[i].support * weightOf(items[i], points);
      losses[i * sure + j] = losses[j * sure + i] = lost / items[i].of->falseAlarms.evidenceScale();
    }
  });
  std::vector<std::size_t> keptItems;
  // Keeps an item if the evidence that those kept before leave it has that rate.
  const auto keep = [&](std::size_t i, double allowed, std::vector<VerifiedInstance>& kept) {
    const Item& item = items[i];
    std::vector<bool> taken(item.points.size());
    for (const std::size_t j : keptItems) {
      const std::vector<bool> points = j < i ? explained[i * count + j] : explainedBy(item, items[j]);
      for (std::size_t p = 0; p < taken.size(); ++p)
        if (points[p]) taken[p] = true;
    }
    const double evidence = item.pose->evidence - item.support * weightOf(item, taken);
    if (evidence < item.of->falseAlarms.evidenceOf(allowed)) return;
    kept.push_back({item.candidates, item.instance, evidence});
    keptItems.push_back(i);
  };
  VerifiedInstances verified;
  for (const std::size_t i : bestSubset(gains, losses)) keep(i, rate, verified.sure);
  for (std::size_t i = 0; i < count; ++i)
    if (std::ranges::find(keptItems, i) == keptItems.end())
      keep(i, FalseAlarmModel::maybe(rate), verified.maybe);
  return verified;
}

}  // namespace estancia
