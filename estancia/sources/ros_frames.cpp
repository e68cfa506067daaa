// SPDX-License-Identifier: Apache-2.0
#include "estancia/sources/ros_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/readers/message_image.hpp"

namespace estancia {
namespace {

constexpr std::size_t maxMessagesKept = 6;
constexpr std::int64_t maxDepthAway = 50'000'000;        // [ns]
constexpr std::int64_t transformsKept = 10'000'000'000;  // [ns]

constexpr const char* bodyRoot = "odometry";

ros::SerializedMessage inCdr(std::span<const std::byte> bytes) {
  return {bytes, ros::Encoding::cdr};
}

}  // namespace

RosFrames::RosFrames(const RosFrameOptions& options)
    : options_(options), transforms_(options.maxPoseGap), body_(options.maxPoseGap) {}

/// Runs `work`; what it throws is a trouble until it succeeds again.
template <class Work>
void RosFrames::understand(const char* what, const Work& work) {
  try {
    work();
  } catch (const Error& e) {
    const std::lock_guard lock(mutex_);
    troubles_[what] = fmt::format("{}: {}", what, e.what());
    return;
  }
  const std::lock_guard lock(mutex_);
  troubles_.erase(what);
  changed_.notify_all();
}

/// Messages without a stamp have the time when they came.
void RosFrames::keep(std::deque<Message>& messages, std::span<const std::byte> bytes,
                     const std::string& type) {
  const char* what = &messages == &images_ ? "images" : "depth images";
  understand(what, [&] {
    const ros::Header header = ros::readHeader(inCdr(bytes));
    Message message{header.stamp, header.frame, type, {bytes.begin(), bytes.end()}, Clock::now(), 0};
    if (message.stamp == 0)
      message.stamp = std::chrono::duration_cast<std::chrono::nanoseconds>(
                          std::chrono::system_clock::now().time_since_epoch())
                          .count();
    const std::lock_guard lock(mutex_);
    if (&messages == &images_) message.number = ++received_;
    messages.push_back(std::move(message));
    if (messages.size() > maxMessagesKept) messages.pop_front();
  });
}

void RosFrames::addImage(std::span<const std::byte> message, const std::string& type) {
  keep(images_, message, type);
}

void RosFrames::addDepth(std::span<const std::byte> message, const std::string& type) {
  keep(depths_, message, type);
}

void RosFrames::readCamera(std::span<const std::byte> message, bool isRectified, const char* what,
                           std::optional<io::Undistortion>& camera) {
  {
    const std::lock_guard lock(mutex_);
    if (camera) return;  // a camera is calibrated once
  }
  understand(what, [&] {
    const io::Undistortion known(ros::readCameraInfo(inCdr(message)), isRectified);
    const std::lock_guard lock(mutex_);
    camera = known;
  });
}

void RosFrames::addCamera(std::span<const std::byte> message) {
  readCamera(message, options_.isRectified, "camera", camera_);
}

void RosFrames::addDepthCamera(std::span<const std::byte> message) {
  readCamera(message, false, "camera of depth", depthCamera_);
}

void RosFrames::addTransforms(std::span<const std::byte> message, bool areStatic) {
  understand("transforms", [&] {
    const auto transforms = ros::readPoses(inCdr(message), "tf2_msgs/TFMessage");
    const std::lock_guard lock(mutex_);
    for (const ros::StampedPose& transform : transforms) {
      transforms_.add(transform, areStatic);
      if (!areStatic) transforms_.forgetBefore(transform.header.stamp - transformsKept);
    }
  });
}

void RosFrames::addPose(std::span<const std::byte> message, const std::string& type) {
  understand("poses", [&] {
    for (ros::StampedPose pose : ros::readPoses(inCdr(message), type)) {
      const std::lock_guard lock(mutex_);
      if (bodyName_.empty()) bodyName_ = pose.child;
      pose.header.frame = bodyRoot;
      pose.child = "body";
      body_.add(pose, false);
      body_.forgetBefore(pose.header.stamp - transformsKept);
    }
  });
}

const RosFrames::Message* RosFrames::depthOf(std::int64_t stamp) const {
  const auto away = [stamp](const Message& depth) { return std::abs(depth.stamp - stamp); };
  const auto nearest = std::ranges::min_element(depths_, {}, away);
  return nearest != depths_.end() && away(*nearest) <= maxDepthAway ? &*nearest : nullptr;
}

/// By transforms where one moves above the camera, else by the body's poses.
std::optional<Pose> RosFrames::poseOf(const Message& image) const {
  if (transforms_.isMoving(image.frame)) {
    const auto camera = transforms_.find(transforms_.rootOf(image.frame), image.frame, image.stamp);
    return camera ? std::optional(estancia::poseOf(*camera)) : std::nullopt;
  }
  const auto body = body_.find(bodyRoot, "body", image.stamp);
  if (!body) return std::nullopt;
  const std::string on = bodyName_.empty() ? transforms_.rootOf(image.frame) : bodyName_;
  const auto mount =
      transforms_.has(image.frame) ? transforms_.find(on, image.frame, image.stamp) : std::nullopt;
  return estancia::poseOf(
      *body * (on == image.frame ? cv::Affine3d::Identity() : mount.value_or(ros::bodyFromCameraAhead)));
}

bool RosFrames::isWhole(const Message& image) const {
  return (!options_.depth || depthOf(image.stamp) != nullptr) && (!options_.poses || poseOf(image));
}

/// The newest image that has all that belongs to it; else the newest, once one has waited long enough.
const RosFrames::Message* RosFrames::toTake() const {
  const Message* newest = nullptr;
  bool isLate = false;
  for (const Message& image : images_) {
    if (image.number <= taken_) continue;
    if (isWhole(image)) newest = &image;
    isLate = isLate || Clock::now() - image.arrived >= options_.patience;
  }
  return newest != nullptr || !isLate ? newest : &images_.back();
}

std::optional<LiveFrame> RosFrames::newest(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  const auto end = Clock::now() + patience;
  constexpr auto look = std::chrono::milliseconds(10);  // an image may become late meanwhile
  const Message* found = toTake();
  while (found == nullptr && Clock::now() < end) {
    changed_.wait_for(lock, look);
    found = toTake();
  }
  if (found == nullptr) return std::nullopt;
  const Message image = *found;
  std::optional<Message> depth;
  if (const Message* of = options_.depth ? depthOf(image.stamp) : nullptr) depth = *of;
  LiveFrame live;
  live.frame.pose = options_.poses ? poseOf(image) : std::nullopt;
  live.dropped = image.number - taken_ - 1;
  taken_ = image.number;
  lock.unlock();
  try {
    decode(image, depth, live);
  } catch (const Error& e) {
    lock.lock();
    troubles_["images"] = e.what();
    return std::nullopt;
  }
  live.arrived = image.arrived;
  live.frame.timestamp = static_cast<double>(image.stamp) * 1e-9;
  live.frame.name =
      fmt::format("{}.{:09}", image.stamp / 1'000'000'000, std::abs(image.stamp % 1'000'000'000));
  if (live.frame.name == lastName_) live.frame.name += '+';
  lastName_ = live.frame.name;
  return live;
}

void RosFrames::decode(const Message& image, const std::optional<Message>& depth, LiveFrame& live) {
  std::unique_lock lock(mutex_);
  const std::optional<io::Undistortion> camera = camera_;
  lock.unlock();
  live.image = io::imageOf(inCdr(image.bytes), image.type);
  if (camera) live.image = camera->image(live.image);
  if (depth) understand("depth images", [&] { live.depth = decodedDepth(*depth, image); });
}

/// Depth as the camera of the images sees it.
cv::Mat RosFrames::decodedDepth(const Message& depth, const Message& image) {
  std::unique_lock lock(mutex_);
  const std::optional<io::Undistortion> camera = camera_, own = depthCamera_;
  const auto mount =
      depth.frame == image.frame ? std::nullopt : transforms_.find(image.frame, depth.frame, image.stamp);
  lock.unlock();
  const cv::Mat meters = io::depthOf(inCdr(depth.bytes), depth.type, options_.depthScale);
  if (depth.type == "sensor_msgs/PointCloud2") return meters;
  if (camera && own && mount)
    return io::registerDepth(own->depth(meters), own->camera(), *mount, camera->camera());
  return camera ? camera->depth(meters) : meters;
}

std::optional<CameraIntrinsics> RosFrames::intrinsics() const {
  const std::lock_guard lock(mutex_);
  return camera_ ? std::optional(camera_->camera()) : std::nullopt;
}

std::string RosFrames::trouble() const {
  const std::lock_guard lock(mutex_);
  return troubles_.empty() ? "" : troubles_.begin()->second;
}

}  // namespace estancia
