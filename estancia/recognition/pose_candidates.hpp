// Pose candidates: which poses are instances of models, alone and together, by their rate of false alarms.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "estancia/recognition/prepared.hpp"

namespace estancia {

/// The null model of verification by evidence. Which evidence is chance depends on the scene: curved things
/// side by side agree with a wrong model more than a table does, noise more than none. It is estimated from
/// the best wrong poses of the same search: the best pose of an absent model exceeds the mean of the eight
/// next ones, elsewhere in the scene, by an amount whose tail is exponential. Its scale grows with the root
/// of that mean, as for sums of independent chances. Constants: docs/measured/recognition.md.
class FalseAlarmModel {
 public:
  /// Best wrong poses that count.
  static constexpr std::size_t wrongPoses = 8;

  FalseAlarmModel() : FalseAlarmModel(std::vector<double>{}) {}
  /// `wrong`: the evidence of poses elsewhere, in any order. Where there are fewer than wrongPoses, as in a
  /// scene of nothing but the model, what is usual takes their place.
  explicit FalseAlarmModel(std::vector<double> wrong);

  /// Mean evidence of the best wrong poses.
  double chance() const { return chance_; }
  /// Probability that a model that is not in the scene has a pose with so much evidence. In (0, 1].
  double rate(double evidence) const;
  /// The evidence with that rate: the inverse, for a rate in (0, 1].
  double evidenceOf(double rate) const;
  /// The rate up to which a pose may be an instance, where that of instances is allowed: ten times as much.
  static double maybe(double rate);
  /// The evidence by which the rate falls by a factor of e.
  double evidenceScale() const;

 private:
  double chance_ = 0, scale_ = 0;
};

/// Refers to the model and the scene that were searched.
struct PoseCandidates {
  const PreparedModel* model = nullptr;
  const PreparedScene* scene = nullptr;
  /// Both at the scales of the search.
  std::shared_ptr<const PreparedModel::Described> modelSurface;
  std::shared_ptr<const PreparedScene::Described> sceneSurface;
  /// With verification by evidence those that are or may be instances, best first. Else
  /// those that the verification accepts.
  std::vector<PoseHypothesis> instances;
  /// All that were refined, best first, accepted or not.
  std::vector<PoseHypothesis> poses;
  /// False alarms of the model in the scene.
  FalseAlarmModel falseAlarms;
};

/// Which of `poses`, best first, are instances at places of their own, `apart` [m] from each other at
/// `center`, with a rate of false alarms of at most `rate`; and the null model by which they are judged. The
/// wrong poses are those elsewhere than the instances: the last pose that stands out from all behind it, with
/// a rate of 0.01, ends the instances. So no rate depends on what is allowed.
struct Instances {
  std::vector<PoseHypothesis> poses;
  FalseAlarmModel falseAlarms;
};
Instances instancesOf(const std::vector<PoseHypothesis>& poses, const cv::Point3d& center, double apart,
                      double rate);

/// An instance with the evidence that remains for it among others.
struct VerifiedInstance {
  /// Indices of its model's candidates, and of the instance among them.
  std::size_t candidates = 0, instance = 0;
  /// Evidence from points that no better instance explains.
  double evidence = 0;
};

struct VerifiedInstances {
  std::vector<VerifiedInstance> sure, maybe;  ///< most evident first
};

/// Hypotheses of several models exclude each other where they explain the same points of the scene, in the
/// manner of Aldoma et al. (ECCV 2012), who anneal: here the choice is exact for up to 24 that overlap. The
/// set with the most Σ (evidence − threshold) / scale is chosen, in which evidence on a point counts for the
/// better instance alone; of the chosen, those are kept whose own evidence still has a rate of false alarms
/// of at most `rate`. Others are `maybe` there, by what these leave them (FalseAlarmModel::maybe()).
VerifiedInstances verifyTogether(const std::vector<PoseCandidates>& candidates, double rate, int threads = 1);

/// The subset of items that maximizes Σ gains − Σ losses of its pairs: exactly by branch and bound for items
/// that losses connect, up to 24 of them, else greedily, largest gain first. `losses`: row-major,
/// gains.size()², symmetric, not negative. Ascending indices.
std::vector<std::size_t> bestSubset(const std::vector<double>& gains, const std::vector<double>& losses);

}  // namespace estancia
