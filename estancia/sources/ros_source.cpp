// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/ros_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <functional>
#include <thread>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/readers/bag_topics.hpp"

namespace estancia {
namespace {

using std::chrono::milliseconds;
using RosClock = std::chrono::steady_clock;

constexpr std::string_view rosScheme = "ros2:";
/// Discovery takes a second on most networks.
constexpr milliseconds discovery{5000}, firstCamera{3000}, betweenLooks{50}, listing{2000};

/// Looks until `isThere`, or until the time is over. Returns whether it is there.
bool waitFor(milliseconds patience, const std::function<bool()>& isThere) {
  const auto end = RosClock::now() + patience;
  while (!isThere()) {
    if (RosClock::now() >= end) return false;
    std::this_thread::sleep_for(betweenLooks);
  }
  return true;
}

bool isImageType(const std::string& type) {
  return type == "sensor_msgs/Image" || type == "sensor_msgs/CompressedImage";
}

std::string namesOf(const std::vector<ros::DdsTopic>& topics) {
  std::vector<std::string> names;
  for (const ros::DdsTopic& topic : topics) names.push_back(printable(topic.name));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string whatThereIs(const std::vector<ros::DdsTopic>& topics) {
  return topics.empty() ? "there is none; `estancia live --list` shows what is published, see ROS_DOMAIN_ID"
                        : "there are: " + namesOf(topics);
}

template <class Is>
std::vector<ros::DdsTopic> topicsThat(const ros::DdsNode& node, const Is& is) {
  std::vector<ros::DdsTopic> found;
  std::ranges::copy_if(node.topics(), std::back_inserter(found),
                       [&](const ros::DdsTopic& topic) { return topic.writers > 0 && is(topic); });
  return found;
}

/// The topic that is named, else the only one that could be; nothing for "none", and where several could be.
std::optional<ros::DdsTopic> chosenTopic(const ros::DdsNode& node, const std::string& name,
                                         const char* option,
                                         const std::function<bool(const ros::DdsTopic&)>& fits,
                                         const std::function<bool(const ros::DdsTopic&)>& fitsUnnamed) {
  if (name == "none") return std::nullopt;
  if (name.empty()) {
    const auto topics = topicsThat(node, fitsUnnamed);
    return topics.size() == 1 ? std::optional(topics.front()) : std::nullopt;
  }
  std::vector<ros::DdsTopic> topics;
  waitFor(discovery, [&] {
    topics = topicsThat(node, [&](const ros::DdsTopic& topic) {
      return fits(topic) && (topic.name == name || topic.name == "/" + name);
    });
    return !topics.empty();
  });
  if (topics.empty())
    fail(ErrorCode::unknownName, "nobody publishes {} ({}) of a type that fits; {}", printable(name), option,
         whatThereIs(topicsThat(node, fits)));
  return topics.front();
}

}  // namespace

bool isRosTopic(const std::string& source) {
  return source.starts_with(rosScheme);
}

int rosDomain() {
  const char* const text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  int domain = -1;
  const std::string_view digits(text);
  const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), domain);
  if (problem != std::errc{} || end != digits.data() + digits.size() || domain < 0 || domain > 232)
    fail(ErrorCode::invalidOption, "ROS_DOMAIN_ID is \"{}\"; give a number from 0 to 232", printable(digits));
  return domain;
}

RosSource::RosSource(const std::string& source, const RosSourceOptions& options,
                     std::unique_ptr<ros::DdsNode> node)
    : source_(source), node_(std::move(node)) {
  const std::string named = source.substr(rosScheme.size());
  const auto isImage = [](const ros::DdsTopic& topic) { return isImageType(topic.type); };
  if (named.empty() || named == "none")
    fail(ErrorCode::invalidInput, "{} names no topic; write ros2:/camera/image_raw (`estancia live --list`)",
         printable(source));
  const ros::DdsTopic images = *chosenTopic(*node_, named, "ros2:", isImage, isImage);
  imageTopic_ = images.name;
  subscribe(options);
}

void RosSource::subscribe(const RosSourceOptions& options) {
  const auto isDepth = [this](const ros::DdsTopic& topic) {
    return topic.name != imageTopic_ && (isImageType(topic.type) || topic.type == "sensor_msgs/PointCloud2");
  };
  // The content is known with the first message: unnamed, only a raw topic with "depth" in its name is taken.
  const auto saysDepth = [&](const ros::DdsTopic& topic) {
    return isDepth(topic) && topic.type == "sensor_msgs/Image" &&
           topic.name.find("depth") != std::string::npos;
  };
  const auto isPoses = [](const ros::DdsTopic& topic) {
    return ros::isPoseType(topic.type) && !topic.type.starts_with("tf");
  };
  const auto isTf = [](const ros::DdsTopic& topic) { return topic.type == "tf2_msgs/TFMessage"; };
  const auto depth = chosenTopic(*node_, options.depthTopic, "--depth", isDepth, saysDepth);
  const auto poses = chosenTopic(
      *node_, options.odomTopic == "tf" ? "" : options.odomTopic, "--odom",
      [&](const ros::DdsTopic& topic) { return isPoses(topic) || isTf(topic); }, isPoses);
  const bool wantsPoses = options.odomTopic != "none";
  const auto moving = topicsThat(
      *node_, [&](const ros::DdsTopic& topic) { return isTf(topic) && !topic.name.ends_with("tf_static"); });
  hasPoses_ = wantsPoses && (poses || !moving.empty());
  if (depth) depthTopic_ = depth->name;

  RosFrameOptions joined;
  joined.depth = depth.has_value();
  joined.poses = hasPoses_;
  joined.depthScale = options.depthScale;
  joined.maxPoseGap = options.maxPoseGap;
  joined.isRectified = imageTopic_.find("rect", io::cameraNamespace(imageTopic_).size()) != std::string::npos;
  frames_ = std::make_unique<RosFrames>(joined);
  RosFrames& frames = *frames_;
  const auto take = [this](const std::string& topic, const std::string& type,
                           std::function<void(std::span<const std::byte>)> use) {
    subscriptions_.push_back(node_->subscribe(topic, type, std::move(use)));
  };
  std::string imageType = "sensor_msgs/Image";
  for (const ros::DdsTopic& topic : node_->topics())
    if (topic.name == imageTopic_) imageType = topic.type;
  take(imageTopic_, imageType, [&frames, imageType](auto message) { frames.addImage(message, imageType); });
  take(io::cameraNamespace(imageTopic_) + "/camera_info", "sensor_msgs/CameraInfo",
       [&frames](auto message) { frames.addCamera(message); });
  if (depth) {
    const std::string type = depth->type;
    take(depthTopic_, type, [&frames, type](auto message) { frames.addDepth(message, type); });
    take(io::cameraNamespace(depthTopic_) + "/camera_info", "sensor_msgs/CameraInfo",
         [&frames](auto message) { frames.addDepthCamera(message); });
  }
  for (const char* tf : {"/tf", "/tf_static"}) {
    const bool isStatic = std::string_view(tf).ends_with("static");
    if (!isStatic && !wantsPoses) continue;
    take(tf, "tf2_msgs/TFMessage",
         [&frames, isStatic](auto message) { frames.addTransforms(message, isStatic); });
  }
  if (wantsPoses && poses && !isTf(*poses)) {
    const std::string type = poses->type;
    take(poses->name, type, [&frames, type](auto message) { frames.addPose(message, type); });
  }
  if (depth) waitFor(firstCamera, [&frames] { return frames.intrinsics().has_value(); });
}

std::string RosSource::trouble() const {
  if (const std::string trouble = frames_->trouble(); !trouble.empty()) return trouble;
  const ros::DdsCounts counts = subscriptions_.front()->counts();
  if (!counts.trouble.empty()) return counts.trouble;
  if (counts.writers == 0) return fmt::format("nobody publishes {} now: waiting for it", imageTopic_);
  if (!depthTopic_.empty() && !frames_->intrinsics())
    return fmt::format("no camera info of {}: depth is not used without it", imageTopic_);
  return "";
}

std::vector<ros::DdsTopic> discoveredTopics(const ros::DdsNode& node) {
  std::this_thread::sleep_for(listing);
  auto topics = topicsThat(node, [](const ros::DdsTopic&) { return true; });
  std::ranges::sort(topics, {}, &ros::DdsTopic::name);
  return topics;
}

std::string topicTable(const std::vector<ros::DdsTopic>& topics) {
  std::string table = fmt::format("{:<48} {:<36} {:>7}  reliability\n", "topic", "type", "writers");
  for (const ros::DdsTopic& topic : topics)
    table +=
        fmt::format("{:<48} {:<36} {:>7}  {}\n", printable(topic.name), printable(topic.type), topic.writers,
                    topic.writers == 0 ? ""
                    : topic.reliable   ? "reliable"
                                       : "best effort");
  return table;
}

}  // namespace estancia
