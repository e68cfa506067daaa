// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/bag_topics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/sequences/listed_sequence.hpp"

namespace estancia::io {
namespace {

constexpr const char* noTopic = "none";

/// A topic of images, and the content of its first readable message.
struct ImageTopic {
  std::size_t topic = 0;
  ImageContent content = ImageContent::unknown;
  std::string frame;
};

std::string withoutTransport(std::string name) {
  for (const char* suffix : {"/compressed", "/compressedDepth"})
    if (name.ends_with(suffix)) name.resize(name.size() - std::string_view(suffix).size());
  return name;
}

/// "/camera/depth/image_raw"; its last component alone is "image_raw".
std::string leafOf(const std::string& topic) {
  return topic.substr(topic.rfind('/') + 1);
}

class TopicChoice {
 public:
  TopicChoice(const ros::Bag& bag, const SequenceOptions& options) : bag_(bag), options_(options) {
    findImageTopics();
  }

  BagTopics choose() {
    chooseImages();
    if (chosen_.images) {
      chosen_.imageCamera = cameraOf(chosen_.images->topic);
      chooseDepth();
    }
    choosePoses();
    return std::move(chosen_);
  }

 private:
  const ros::BagTopic& topic(std::size_t i) const { return bag_.topics()[i]; }
  static bool isImage(const ros::BagTopic& topic) {
    return topic.type == "sensor_msgs/Image" || topic.type == "sensor_msgs/CompressedImage" ||
           topic.type == "sensor_msgs/PointCloud2";
  }

  void findImageTopics() {
    std::vector<std::size_t> looked(bag_.topics().size(), 0);
    std::vector<bool> isDone(bag_.topics().size(), true);
    std::size_t open = 0;
    for (std::size_t i = 0; i < bag_.topics().size(); ++i)
      if (isImage(topic(i)) && topic(i).encoding && topic(i).messages > 0) {
        isDone[i] = false;
        ++open;
      }
    constexpr std::size_t tries = 3;
    for (std::size_t m = 0; m < bag_.messages().size() && open > 0; ++m) {
      const std::size_t i = bag_.messages()[m].topic;
      if (isDone[i]) continue;
      ImageTopic found{i, ImageContent::unknown, ""};
      try {
        const ros::Payload payload = bag_.read(m);
        found.content = contentOf({payload.bytes, *topic(i).encoding}, topic(i).type, found.frame);
      } catch (const Error&) {  // the next one may be sound
        if (++looked[i] < tries) continue;
      }
      const bool isScan =
          topic(i).type == "sensor_msgs/PointCloud2" && found.content == ImageContent::unknown;
      if (!isScan) images_.push_back(found);
      isDone[i] = true;
      --open;
    }
  }

  void chooseImages() {
    std::vector<ImageTopic> color, gray;
    std::vector<std::size_t> possible;
    for (const ImageTopic& image : images_) {
      if (image.content == ImageContent::color) color.push_back(image);
      if (image.content == ImageContent::gray) gray.push_back(image);
      if (image.content != ImageContent::unknown) possible.push_back(image.topic);
    }
    if (!options_.imageTopic.empty()) {
      chosen_.images = ChosenTopic{named(options_.imageTopic, "--image", possible), "as --image says"};
      return;
    }
    for (const auto* candidates : {&color, &gray}) {
      if (candidates->empty()) continue;
      const std::vector<std::size_t> topics = onlyCamera(*candidates);
      if (!topics.empty()) {
        const char* what = candidates == &color ? "the only camera with color" : "the only camera";
        chosen_.images = ChosenTopic{bestOfCamera(topics), what};
        return;
      }
      std::vector<std::size_t> all;
      for (const ImageTopic& image : *candidates) all.push_back(image.topic);
      chosen_.whyNoImages = fmt::format("it has several cameras; choose one by --image: {}", listOf(all));
      return;
    }
    std::vector<std::size_t> all;
    for (const ImageTopic& image : images_) all.push_back(image.topic);
    chosen_.whyNoImages =
        images_.empty()
            ? "it has no topic of sensor_msgs/Image or CompressedImage with messages"
            : fmt::format("its topics of images hold depth only, or encodings that are not read: {}",
                          listOf(all));
  }

  void chooseDepth() {
    std::vector<ImageTopic> candidates;
    std::vector<std::size_t> possible;
    for (const ImageTopic& image : images_)
      if (image.content == ImageContent::depth && image.topic != chosen_.images->topic) {
        candidates.push_back(image);
        possible.push_back(image.topic);
      }
    if (options_.depthTopic == noTopic) return;
    if (!options_.depthTopic.empty()) {
      chosen_.depth = ChosenTopic{named(options_.depthTopic, "--depth", possible), "as --depth says"};
    } else {
      const std::string& frame = imageTopic(chosen_.images->topic).frame;
      std::vector<ImageTopic> sameView;
      std::ranges::copy_if(candidates, std::back_inserter(sameView),
                           [&](const ImageTopic& image) { return !frame.empty() && image.frame == frame; });
      if (const auto aligned = onlyCamera(sameView); !aligned.empty())
        chosen_.depth = ChosenTopic{bestOfCamera(aligned), "the only depth in the frame of the images"};
      else if (const auto topics = onlyCamera(candidates); !topics.empty())
        chosen_.depth = ChosenTopic{bestOfCamera(topics), "the only depth"};
      else if (!candidates.empty())
        chosen_.warnings.push_back(fmt::format(
            "several topics hold depth, and none is used; choose one by --depth: {}", listOf(possible)));
    }
    if (chosen_.depth) chosen_.depthCamera = cameraOf(chosen_.depth->topic);
  }

  void choosePoses() {
    std::vector<std::size_t> transforms, others;
    for (std::size_t i = 0; i < bag_.topics().size(); ++i) {
      if (!ros::isPoseType(topic(i).type) || topic(i).messages == 0 || !topic(i).encoding) continue;
      const bool isTransforms = topic(i).type.starts_with("tf");
      if (!isTransforms) others.push_back(i);
      if (isTransforms && !topic(i).name.ends_with("tf_static")) transforms.push_back(i);
    }
    std::vector<std::size_t> possible = transforms;
    possible.insert(possible.end(), others.begin(), others.end());
    if (options_.odomTopic == noTopic) return;
    if (!options_.odomTopic.empty()) {
      chosen_.poses = {{named(options_.odomTopic, "--odom", possible), "as --odom says"}};
      return;
    }
    if (!transforms.empty()) chosen_.poses.push_back({transforms.front(), "transforms of the robot"});
    if (others.size() == 1)
      chosen_.poses.push_back({others.front(), "the only poses"});
    else if (transforms.empty() && !others.empty())
      chosen_.warnings.push_back(fmt::format(
          "several topics hold poses, and none is used; choose one by --odom: {}", listOf(others)));
  }

  /// Camera topic of the same namespace, else the only one of the bag.
  std::optional<ChosenTopic> cameraOf(std::size_t images) const {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < bag_.topics().size(); ++i)
      if (topic(i).type == "sensor_msgs/CameraInfo" && topic(i).messages > 0 && topic(i).encoding)
        all.push_back(i);
    const std::string name = cameraNamespace(topic(images).name) + "/camera_info";
    for (const std::size_t i : all)
      if (topic(i).name == name) return ChosenTopic{i, "of the same namespace"};
    if (all.size() == 1) return ChosenTopic{all.front(), "the only one"};
    return std::nullopt;
  }

  /// The topic that an option names, with or without its leading slash.
  std::size_t named(const std::string& name, const char* option,
                    const std::vector<std::size_t>& possible) const {
    for (const std::size_t i : possible)
      if (topic(i).name == name || topic(i).name == "/" + name) return i;
    const auto& topics = bag_.topics();
    const auto other = std::ranges::find_if(
        topics, [&](const ros::BagTopic& t) { return t.name == name || t.name == "/" + name; });
    const std::string list =
        possible.empty() ? "the bag has none that could be" : "it can be " + listOf(possible);
    if (other != topics.end())
      fail(ErrorCode::unknownName, "{} {} cannot be used: it is of type {} with {} messages; {}", option,
           printable(name), printable(other->type), other->messages, list);
    fail(ErrorCode::unknownName, "the bag has no topic {} ({}); {}", printable(name), option, list);
  }

  /// The topics of the one camera among the candidates; all of them where there are several.
  std::vector<std::size_t> onlyCamera(const std::vector<ImageTopic>& candidates) const {
    std::map<std::string, std::vector<std::size_t>> cameras;
    for (const ImageTopic& candidate : candidates)
      cameras[cameraNamespace(topic(candidate.topic).name)].push_back(candidate.topic);
    if (cameras.size() == 1) return cameras.begin()->second;
    return {};
  }

  /// One camera offers images raw, rectified and compressed: the most messages, of these the raw ones.
  std::size_t bestOfCamera(std::vector<std::size_t> topics) const {
    const auto rank = [this](std::size_t i) {
      const std::string& name = topic(i).name;
      const std::string leaf = leafOf(withoutTransport(name));
      return std::tuple(topic(i).type == "sensor_msgs/PointCloud2",
                        -static_cast<std::ptrdiff_t>(topic(i).messages), withoutTransport(name) != name,
                        leaf.find("color") == std::string::npos, name);
    };
    return *std::ranges::min_element(topics, {}, rank);
  }

  std::string listOf(const std::vector<std::size_t>& topics) const {
    std::vector<std::string> names;
    for (const std::size_t i : topics) names.push_back(printable(topic(i).name));
    return fmt::format("{}", fmt::join(names, ", "));
  }

  const ImageTopic& imageTopic(std::size_t i) const {
    return *std::ranges::find(images_, i, &ImageTopic::topic);
  }

  const ros::Bag& bag_;
  const SequenceOptions& options_;
  std::vector<ImageTopic> images_;
  BagTopics chosen_;
};

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

std::string cameraNamespace(const std::string& topic) {
  const std::string base = withoutTransport(topic);
  return base.substr(0, base.rfind('/') == std::string::npos ? 0 : base.rfind('/'));
}

BagTopics chooseTopics(const ros::Bag& bag, const SequenceOptions& options) {
  return TopicChoice(bag, options).choose();
}

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

namespace estancia {
namespace {

double secondsBetween(std::int64_t from, std::int64_t to) {
  return static_cast<double>(to - from) * 1e-9;
}

void addTimes(const ros::Bag& bag, BagSummary& summary) {
  const auto& messages = bag.messages();
  if (messages.empty()) return;
  summary.duration = secondsBetween(messages.front().time, messages.back().time);
  struct Times {
    std::int64_t first = 0, last = 0;
    bool isBegun = false;
  };
  std::vector<Times> times(summary.topics.size());
  for (const ros::BagMessage& message : messages) {
    Times& of = times[message.topic];
    double& gap = summary.topics[message.topic].longestGap;
    if (of.isBegun) gap = std::max(gap, secondsBetween(of.last, message.time));
    if (!of.isBegun) of.first = message.time;
    of.last = message.time;
    of.isBegun = true;
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double seconds = secondsBetween(times[i].first, times[i].last);
    if (seconds > 0) summary.topics[i].rate = static_cast<double>(summary.topics[i].messages - 1) / seconds;
  }
}

/// The frame of the images: of the first message that can be read.
std::string frameOfImages(const ros::Bag& bag, std::size_t topic) {
  for (std::size_t m = 0; m < bag.messages().size(); ++m) {
    if (bag.messages()[m].topic != topic) continue;
    try {
      const ros::Payload payload = bag.read(m);
      return ros::readHeader({payload.bytes, *bag.topics()[topic].encoding}).frame;
    } catch (const Error&) {  // the next one may be sound
    }
  }
  return "";
}

}  // namespace

BagSummary summarizeBag(const std::filesystem::path& path, const SequenceOptions& options) {
  return io::opened(path, [&] {
    const std::unique_ptr<ros::Bag> bag = ros::openBag(path);
    const io::BagTopics topics = io::chooseTopics(*bag, options);
    BagSummary summary;
    summary.warnings = bag->warnings();
    summary.whyNoImages = topics.whyNoImages;
    for (const ros::BagTopic& topic : bag->topics())
      summary.topics.push_back({printable(topic.name), printable(topic.type), topic.messages, 0, 0, "",
                                topic.encoding ? "" : "its messages are " + printable(topic.encodingName)});
    addTimes(*bag, summary);
    const auto use = [&summary](const std::optional<io::ChosenTopic>& chosen, const char* what) {
      if (!chosen) return;
      TopicSummary& topic = summary.topics[chosen->topic];
      topic.use += topic.use.empty() ? what : std::string(", ") + what;
      topic.why = chosen->why;
    };
    use(topics.images, "images");
    use(topics.depth, "depth");
    use(topics.imageCamera, "camera");
    if (topics.depthCamera && topics.imageCamera && topics.depthCamera->topic != topics.imageCamera->topic)
      use(topics.depthCamera, "camera of depth");
    if (topics.images) {
      const io::BagPoses poses(*bag, topics.poses, frameOfImages(*bag, topics.images->topic),
                               options.maxPoseGap);
      use(poses.topic(), "poses");
    }
    return summary;
  });
}

}  // namespace estancia
