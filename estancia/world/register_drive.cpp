// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/register_drive.hpp"

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/odometry/alignment.hpp"
#include "estancia/session/drive_alignment.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxViews = 24, targetsOfView = 3;
constexpr int levels = 4, width = 160;
constexpr double maxDepth = 8;                      // [m]
constexpr double nearDistance = 1, nearAngle = 45;  // [m], [degrees]: views that may overlap
// [m], [°]: difference up to which two transforms agree
constexpr double sameDistance = 0.15, sameAngle = 5;
constexpr double minOverlap = 0.5, maxRmse = 0.05, maxSpread = 0.1;  // [m]

/// How far apart two views are, in units of what is near.
double apart(const cv::Affine3d& a, const cv::Affine3d& b) {
  const cv::Affine3d motion = a.inv() * b;
  return std::max(cv::norm(motion.translation()) / nearDistance,
                  angleOf(motion) / (nearAngle * std::numbers::pi / 180));
}

/// The nearest views of the map that may overlap one at `pose`.
std::vector<const ObservationPose*> targetsOf(const cv::Affine3d& pose,
                                              std::span<const ObservationPose> map) {
  std::vector<std::pair<double, const ObservationPose*>> found;
  for (const ObservationPose& view : map)
    if (const double distance = apart(pose, view.pose); distance <= 1) found.emplace_back(distance, &view);
  const std::size_t count = std::min(found.size(), targetsOfView);
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count), found.end());
  std::vector<const ObservationPose*> targets;
  for (std::size_t i = 0; i < count; ++i) targets.push_back(found[i].second);
  return targets;
}

class Registration {
 public:
  Registration(std::span<const ObservationPose> drive, std::span<const ObservationPose> map,
               const std::function<Observation(std::size_t)>& observation)
      : drive_(drive), map_(map), observation_(observation) {}

  std::optional<cv::Affine3d> from(const cv::Affine3d& guess) {
    DriveAlignment agreement(sameDistance, sameAngle);
    for (const ObservationPose& view : viewsNear(guess))
      if (const auto pose = poseOfView(view, guess)) agreement.add(poseOf(view.pose), poseOf(*pose));
    const auto found = agreement.estimate();
    return found ? std::optional(found->transform) : std::nullopt;
  }

 private:
  /// Views of the drive where the map has observations, evenly spread.
  std::vector<ObservationPose> viewsNear(const cv::Affine3d& guess) const {
    std::vector<ObservationPose> near;
    for (const ObservationPose& view : drive_)
      if (!targetsOf(guess * view.pose, map_).empty()) near.push_back(view);
    std::vector<ObservationPose> chosen;
    const std::size_t count = std::min(near.size(), maxViews);
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(near[i * near.size() / count]);
    return chosen;
  }

  const odometry::Pyramid& pyramidOf(std::size_t frame) {
    const auto [entry, isNew] = pyramids_.try_emplace(frame);
    if (isNew) {
      const Observation seen = observation_(frame);
      const cv::Mat depth = depthOf(seen);
      const cv::Mat nothing(depth.size(), CV_8UC3, cv::Scalar::all(0));  // gray values are not compared
      entry->second =
          odometry::pyramidOf(odometry::reducedImage(nothing, depth, seen.camera, width, maxDepth), levels);
    }
    return entry->second;
  }

  /// T_map_camera.
  std::optional<cv::Affine3d> poseOfView(const ObservationPose& view, const cv::Affine3d& guess) {
    std::vector<odometry::AlignmentTarget> targets;
    for (const ObservationPose* target : targetsOf(guess * view.pose, map_))
      targets.push_back({&pyramidOf(target->frame), target->pose});
    odometry::AlignmentOptions options;
    options.term = odometry::AlignmentTerm::depth;
    const odometry::Alignment found =
        odometry::align(pyramidOf(view.frame), targets, guess * view.pose, options);
    if (!found.solved || found.overlap < minOverlap || found.rmse > maxRmse || found.spread > maxSpread)
      return std::nullopt;
    return found.transform;
  }

  std::span<const ObservationPose> drive_, map_;
  const std::function<Observation(std::size_t)>& observation_;
  std::map<std::size_t, odometry::Pyramid> pyramids_;
};

}  // namespace

std::optional<cv::Affine3d> registerDrive(std::span<const ObservationPose> drive,
                                          std::span<const ObservationPose> map,
                                          const std::function<Observation(std::size_t)>& observation,
                                          const cv::Affine3d& guess) {
  Registration registration(drive, map, observation);
  const auto near = registration.from(guess);
  return near ? registration.from(*near) : std::nullopt;  // again, from better guesses
}

std::optional<cv::Affine3d> registerDrive(MapStore& map, const WorldStore& seen, const Drive& drive,
                                          const cv::Affine3d& guess) {
  std::vector<ObservationPose> before, since;
  for (const std::size_t frame : seen.observedFrames()) {
    const bool isOfDrive = frame >= drive.firstFrame;
    const auto pose = isOfDrive ? map.givenPose(frame) : map.pose(frame);
    if (pose) (isOfDrive ? since : before).push_back({frame, rigidOf(*pose)});
  }
  const auto observation = [&seen](std::size_t frame) { return seen.observation(frame); };
  return registerDrive(since, before, observation, guess);
}

}  // namespace estancia
