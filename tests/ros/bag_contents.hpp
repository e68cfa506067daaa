// What is in a bag, for comparisons.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "estancia/core/error.hpp"
#include "estancia/ros/bag.hpp"

namespace estancia::test {

/// Messages by topic.
inline std::map<std::string, std::size_t> countsOf(const ros::Bag& bag) {
  std::map<std::string, std::size_t> counts;
  for (const ros::BagTopic& topic : bag.topics()) counts[topic.name] += topic.messages;
  return counts;
}

inline std::string bytesOf(const ros::Bag& bag, std::size_t message) {
  const ros::Payload payload = bag.read(message);
  return {reinterpret_cast<const char*>(payload.bytes.data()), payload.bytes.size()};
}

/// Topic, type, time and bytes of each message that can be read.
using BagContents = std::multiset<std::tuple<std::string, std::string, std::int64_t, std::string>>;
inline BagContents contentsOf(const ros::Bag& bag, std::size_t* unreadable = nullptr) {
  BagContents contents;
  for (std::size_t i = 0; i < bag.messages().size(); ++i) {
    const ros::BagTopic& topic = bag.topics()[bag.messages()[i].topic];
    try {
      contents.emplace(topic.name, topic.type, bag.messages()[i].time, bytesOf(bag, i));
    } catch (const Error&) {
      if (unreadable == nullptr) throw;
      ++*unreadable;
    }
  }
  return contents;
}

}  // namespace estancia::test
