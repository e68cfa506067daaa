// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/bag_poses.hpp"

#include <fmt/format.h>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"

namespace estancia::io {
namespace {

constexpr const char* anyBody = "the robot";

/// Calls `use(poses)` for each message of the topics that can be read. Returns how many cannot be.
template <class IsWanted, class Use>
std::size_t forEachPoses(const ros::Bag& bag, const IsWanted& isWanted, const Use& use) {
  std::size_t broken = 0;
  for (std::size_t m = 0; m < bag.messages().size(); ++m) {
    const ros::BagTopic& topic = bag.topics()[bag.messages()[m].topic];
    if (!topic.encoding || !isWanted(bag.messages()[m].topic)) continue;
    try {
      const ros::Payload payload = bag.read(m);
      use(ros::readPoses({payload.bytes, *topic.encoding}, topic.type), topic);
    } catch (const Error&) {
      ++broken;
    }
  }
  return broken;
}

}  // namespace

BagPoses::BagPoses(const ros::Bag& bag, const std::vector<ChosenTopic>& topics, const std::string& camera,
                   double maxGap)
    : camera_(camera), transforms_(maxGap), poses_(maxGap) {
  readTransforms(bag);
  for (const ChosenTopic& topic : topics) {
    const bool isTransforms = bag.topics()[topic.topic].type.starts_with("tf");
    if (isTransforms ? useTransforms() : usePoses(bag, topic)) {
      topic_ = topic;
      break;
    }
  }
  if (!topic_ && !topics.empty())
    warnings_.push_back(fmt::format(
        "the transforms of the bag do not say where the camera \"{}\" is: its frames have no poses",
        printable(camera)));
}

void BagPoses::readTransforms(const ros::Bag& bag) {
  const std::size_t broken = forEachPoses(
      bag, [&](std::size_t topic) { return bag.topics()[topic].type.starts_with("tf"); },
      [&](const std::vector<ros::StampedPose>& transforms, const ros::BagTopic& topic) {
        for (const ros::StampedPose& transform : transforms)
          transforms_.add(transform, topic.name.ends_with("tf_static"));
      });
  if (broken > 0) warnings_.push_back(fmt::format("{} messages of transforms cannot be read", broken));
}

bool BagPoses::useTransforms() {
  if (camera_.empty() || !transforms_.isMoving(camera_)) return false;
  root_ = transforms_.rootOf(camera_);
  return true;
}

bool BagPoses::usePoses(const ros::Bag& bag, const ChosenTopic& topic) {
  std::string child;
  std::size_t unusable = 0;
  const std::size_t broken = forEachPoses(
      bag, [&](std::size_t i) { return i == topic.topic; },
      [&](const std::vector<ros::StampedPose>& poses, const ros::BagTopic&) {
        for (ros::StampedPose pose : poses) {
          if (pose.child.empty()) pose.child = anyBody;
          if (child.empty()) child = pose.child;
          // The parent of the odometry's frame does not matter: there is only one.
          pose.header.frame = "odometry of " + pose.child;
          if (pose.child != child || !poses_.add(pose, false)) ++unusable;
        }
      });
  const std::string& name = bag.topics()[topic.topic].name;
  if (unusable + broken > 0)
    warnings_.push_back(
        fmt::format("{}: {} poses cannot be used: not finite, no rotation, or of another body",
                    printable(name), unusable + broken));
  if (poses_.empty()) return false;
  body_ = child;
  if (child == camera_) {
    mount_ = cv::Affine3d::Identity();
  } else if (child == anyBody && transforms_.has(camera_)) {
    body_ = transforms_.rootOf(camera_);
  } else if (!transforms_.has(camera_) || transforms_.rootOf(camera_) != transforms_.rootOf(child)) {
    mount_ = ros::bodyFromCameraAhead;
    warnings_.push_back(fmt::format(
        "no transform says how the camera \"{}\" is mounted on \"{}\": it is taken to look straight ahead "
        "from there",
        printable(camera_), printable(child)));
  }
  root_ = "odometry of " + child;
  return true;
}

std::optional<Pose> BagPoses::find(std::int64_t time) const {
  if (!topic_) return std::nullopt;
  if (poses_.empty()) {
    const auto camera = transforms_.find(root_, camera_, time);
    return camera ? std::optional(poseOf(*camera)) : std::nullopt;
  }
  const std::string child = root_.substr(std::string_view("odometry of ").size());
  const auto body = poses_.find(root_, child, time);
  const auto camera = mount_ ? mount_ : transforms_.find(body_, camera_, time);
  return body && camera ? std::optional(poseOf(*body * *camera)) : std::nullopt;
}

}  // namespace estancia::io
