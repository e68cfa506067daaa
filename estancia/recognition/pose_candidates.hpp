// Pose candidates: the best poses of one model in a scene, before they are verified together with those of
// others. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "estancia/recognition/false_alarms.hpp"
#include "estancia/recognition/pose_hypothesis.hpp"
#include "estancia/recognition/prepared.hpp"

namespace estancia {

/// Refers to the model and the scene that were searched.
struct PoseCandidates {
  const PreparedModel* model = nullptr;
  const PreparedScene* scene = nullptr;
  /// Both at the scales of the search.
  std::shared_ptr<const PreparedModel::Described> modelSurface;
  std::shared_ptr<const PreparedScene::Described> sceneSurface;
  /// Instances that are accepted if no other explains their surface, best first; with verification by
  /// evidence. Else those that the verification accepts.
  std::vector<PoseHypothesis> instances;
  /// False alarms of the model in the scene.
  FalseAlarmModel falseAlarms;
};

/// Which of `poses`, best first, are instances at places of their own, `apart` [m] from each other at
/// `center`, with a rate of false alarms of at most `rate`; and the null model by which they are judged. The
/// wrong poses are those elsewhere than the instances: the last pose that stands out from all behind it ends
/// the instances.
struct Instances {
  std::vector<PoseHypothesis> poses;
  FalseAlarmModel falseAlarms;
};
Instances instancesOf(const std::vector<PoseHypothesis>& poses, const cv::Point3d& center, double apart,
                      double rate);

}  // namespace estancia
