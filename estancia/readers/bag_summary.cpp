// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/bag_summary.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>

#include "estancia/core/printable.hpp"
#include "estancia/readers/bag_poses.hpp"
#include "estancia/readers/bag_topics.hpp"
#include "estancia/sequences/format_registry.hpp"

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
