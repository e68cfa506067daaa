// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/pose_candidates.hpp"

#include <algorithm>
#include <utility>

#include "estancia/recognition/distinct_poses.hpp"

namespace estancia {
namespace {

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

}  // namespace

Instances instancesOf(const std::vector<PoseHypothesis>& poses, const cv::Point3d& center, double apart,
                      double rate) {
  Instances found;
  std::vector<PoseHypothesis> places = distinctPoses(poses, center, apart, anyRotation);
  for (std::size_t count = places.size(); count > 0; --count) {
    const FalseAlarmModel falseAlarms(elsewhere(poses, places, count, center, apart));
    const bool accepted = falseAlarms.rate(places[count - 1].evidence) <= rate;
    if (accepted || count == 1) found.falseAlarms = falseAlarms;
    if (!accepted) continue;
    places.resize(count);
    found.poses = std::move(places);
    return found;
  }
  return found;
}

}  // namespace estancia
