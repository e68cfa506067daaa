// Bags of ROS 1 and 2 as sequences: their images in order of time stamps, with depth, camera and poses.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estancia/core/digest.hpp"
#include "estancia/readers/bag_topics.hpp"
#include "estancia/readers/formats.hpp"
#include "estancia/readers/message_image.hpp"
#include "estancia/readers/undistortion.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t noMessage = std::numeric_limits<std::size_t>::max();

/// A message of a topic, by its position in Bag::messages().
struct StampedMessage {
  std::int64_t stamp = 0;
  std::size_t message = noMessage;
};

double secondsOf(std::int64_t nanoseconds) {
  return static_cast<double>(nanoseconds) * 1e-9;
}

/// Half the usual time between two; synchronous pairs are never farther apart. TUM's associate.py: 0.02 s.
std::int64_t maxBetweenDepthAndImage(const std::vector<StampedMessage>& depths) {
  constexpr std::int64_t least = 20'000'000, most = 50'000'000;  // [ns]
  std::vector<std::int64_t> gaps;
  for (std::size_t i = 1; i < depths.size(); ++i) gaps.push_back(depths[i].stamp - depths[i - 1].stamp);
  if (gaps.empty()) return most;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::ranges::nth_element(gaps, middle);
  return std::clamp(*middle / 2, least, most);
}

/// Frames of a bag. Invariant: `images_`, `depths_` and the frames have the same length and order. Life
/// cycle: the constructor reads the index and all stamps, poses and cameras; pixels are read from the bag on
/// request, from any thread.
class BagSequence final : public ListedSequence {
 public:
  BagSequence(const fs::path& path, const SequenceOptions& options)
      : ListedSequence(nameOf(path)),
        bag_(ros::openBag(path)),
        topics_(chooseTopics(*bag_, options)),
        path_(printable(path)),
        depthScale_(options.depthScale) {
    for (const std::string& warning : bag_->warnings()) warn(warning);
    if (!topics_.images)
      fail(ErrorCode::insufficientData, "{}: no images to use: {}; `estancia check` lists its topics", path_,
           topics_.whyNoImages);
    for (const std::string& warning : topics_.warnings) warn(warning);
    images_ = stampsOf(topics_.images->topic, imageFrame_);
    if (images_.empty())
      fail(ErrorCode::malformedFile, "{}: no message of {} can be read", path_,
           printable(topic(*topics_.images).name));
    for (std::size_t i = 0; i < images_.size(); ++i)
      entries_.push_back({fmt::format("frame {:06}", i), secondsOf(images_[i].stamp), {}, {}});
    findDepths();
    if (options.intrinsics.empty()) findCameras();
    findPoses(options);
  }

  cv::Mat image(std::size_t i) const override {
    try {
      const ros::BagTopic& of = topic(*topics_.images);
      const ros::Payload payload = bag_->read(images_.at(i).message);
      const cv::Mat image = imageOf({payload.bytes, *of.encoding}, of.type);
      return camera_ ? camera_->image(image) : image;
    } catch (const Error& e) {
      throw Error(e.code(), fmt::format("{}: {}: {}", path_, entries_[i].name, e.what()));
    }
  }

  std::string fingerprint(std::size_t i) const override {
    const ros::Payload payload = bag_->read(images_.at(i).message);
    const std::string digest =
        sha256({reinterpret_cast<const char*>(payload.bytes.data()), payload.bytes.size()});
    if (!camera_ || !camera_->isNeeded()) return digest;
    const CameraIntrinsics& to = camera_->camera();
    return fmt::format("{} undistorted {} {} {} {}", digest, to.fx, to.fy, to.cx, to.cy);
  }

  bool hasDepth() const override { return topics_.depth.has_value(); }

  cv::Mat depth(std::size_t i) const override {
    const std::size_t message = depths_.at(i).message;
    if (message == noMessage)
      fail(ErrorCode::insufficientData, "{}: {} has no depth image near its time stamp", path_,
           entries_[i].name);
    try {
      const ros::BagTopic& of = topic(*topics_.depth);
      const ros::Payload payload = bag_->read(message);
      const cv::Mat depth = depthOf({payload.bytes, *of.encoding}, of.type, depthScale_);
      if (of.type == "sensor_msgs/PointCloud2") return depth;  // a camera without distortion
      if (depthCamera_ && camera_ && imageFromDepth_)
        return registerDepth(depthCamera_->depth(depth), depthCamera_->camera(), *imageFromDepth_,
                             camera_->camera());
      return camera_ ? camera_->depth(depth) : depth;
    } catch (const Error& e) {
      throw Error(e.code(), fmt::format("{}: depth of {}: {}", path_, entries_[i].name, e.what()));
    }
  }

  double depthScale() const override { return depthScale_; }

  std::optional<double> depthTimestamp(std::size_t i) const override {
    if (!topics_.depth) return std::nullopt;
    return secondsOf(depths_.at(i).stamp);
  }

 private:
  /// A topic's messages by their stamps, without one by the time they were recorded. `frame`: of the first.
  std::vector<StampedMessage> stampsOf(std::size_t topic, std::string& frame) {
    std::vector<StampedMessage> stamps;
    std::size_t broken = 0;
    const ros::BagTopic& of = bag_->topics()[topic];
    for (std::size_t m = 0; m < bag_->messages().size(); ++m) {
      if (bag_->messages()[m].topic != topic) continue;
      try {
        const ros::Payload payload = bag_->read(m);
        const ros::Header header = ros::readHeader({payload.bytes, *of.encoding});
        if (stamps.empty()) frame = header.frame;
        stamps.push_back({header.stamp != 0 ? header.stamp : bag_->messages()[m].time, m});
      } catch (const Error&) {
        ++broken;
      }
    }
    if (broken > 0) warn(fmt::format("{}: {} messages cannot be read", printable(of.name), broken));
    std::ranges::stable_sort(stamps, {}, &StampedMessage::stamp);
    return stamps;
  }

  std::optional<Undistortion> cameraOf(const ChosenTopic& chosen, const ros::BagTopic& images) {
    const ros::BagTopic& of = topic(chosen);
    const bool isRectified =
        images.name.find("rect", cameraNamespace(images.name).size()) != std::string::npos;
    for (std::size_t m = 0; m < bag_->messages().size(); ++m) {
      if (bag_->messages()[m].topic != chosen.topic) continue;
      try {
        const ros::Payload payload = bag_->read(m);
        return Undistortion(ros::readCameraInfo({payload.bytes, *of.encoding}), isRectified);
      } catch (const Error& e) {
        warn(fmt::format("{} is not used: {}; give --intrinsics", printable(of.name), e.what()));
        return std::nullopt;
      }
    }
    return std::nullopt;
  }

  void findDepths() {
    depths_.resize(images_.size());
    if (!topics_.depth) return;
    const std::vector<StampedMessage> all = stampsOf(topics_.depth->topic, depthFrame_);
    if (all.empty()) {
      topics_.depth.reset();
      return;
    }
    const std::int64_t maxAway = maxBetweenDepthAndImage(all);
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const std::int64_t time = images_[i].stamp;
      const auto nearest = nearestInTime(all, time, &StampedMessage::stamp);
      depths_[i] = *nearest;
      if (std::abs(nearest->stamp - time) > maxAway) depths_[i].message = noMessage;
    }
  }

  void findCameras() {
    if (topics_.imageCamera) camera_ = cameraOf(*topics_.imageCamera, topic(*topics_.images));
    const bool hasOwn = topics_.depth && topic(*topics_.depth).type != "sensor_msgs/PointCloud2" &&
                        topics_.depthCamera && topics_.imageCamera &&
                        topics_.depthCamera->topic != topics_.imageCamera->topic;
    if (hasOwn && depthFrame_ != imageFrame_)
      depthCamera_ = cameraOf(*topics_.depthCamera, topic(*topics_.depth));
    if (!camera_ && topics_.depth && topics_.depthCamera)
      camera_ = cameraOf(*topics_.depthCamera, topic(*topics_.depth));
    if (camera_) setIntrinsics(camera_->camera());
  }

  void findPoses(const SequenceOptions& options) {
    const auto topics = options.poses.empty() ? topics_.poses : std::vector<ChosenTopic>{};
    const BagPoses poses(*bag_, topics, imageFrame_, options.maxPoseGap);
    for (const std::string& warning : poses.warnings()) warn(warning);
    if (depthCamera_ && camera_) {
      imageFromDepth_ = poses.findBetween(imageFrame_, depthFrame_, images_.front().stamp);
      if (!imageFromDepth_)
        warn(fmt::format(
            "no transform says where \"{}\" is on \"{}\": depth is taken as it is, though it is not of the "
            "camera of the images",
            printable(depthFrame_), printable(imageFrame_)));
    }
    if (!poses.topic()) return;
    setPoseSource({});
    std::size_t without = 0;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      entries_[i].pose = poses.find(images_[i].stamp);
      if (!entries_[i].pose) ++without;
    }
    if (without > 0)
      warn(fmt::format("{} of {} images have no pose near their time stamp", without, images_.size()));
  }

  const ros::BagTopic& topic(const ChosenTopic& chosen) const { return bag_->topics()[chosen.topic]; }

  std::unique_ptr<ros::Bag> bag_;
  BagTopics topics_;
  std::string path_, imageFrame_, depthFrame_;
  double depthScale_ = 0;
  std::vector<StampedMessage> images_;
  std::vector<StampedMessage> depths_;  // one an image: of the nearest, without a message where it is too far
  std::optional<Undistortion> camera_, depthCamera_;
  std::optional<cv::Affine3d> imageFromDepth_;  // where depth is of another camera
};

}  // namespace

const SequenceFormat bagFormat{"bag",
                               "a bag of ROS 1 (.bag) or ROS 2 (.db3, .mcap, or the folder of rosbag2)",
                               ros::isBag, openAs<BagSequence>};

}  // namespace estancia::io
