// False-alarm model: how much evidence wrong poses of a model reach in a scene, so that acceptance means the
// same rate of false alarms in every scene. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

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
  /// The evidence by which the rate falls by a factor of e.
  double evidenceScale() const;

 private:
  double chance_ = 0, scale_ = 0;
};

}  // namespace estancia
