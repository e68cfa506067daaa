// ROS 2 topics without ROS: subscriptions and publications by DDS, in a module that is opened when needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace estancia::ros {

/// A topic of the ROS graph, by ROS 2's names.
struct DdsTopic {
  /// "/camera/image_raw"
  std::string name;
  /// "sensor_msgs/Image"
  std::string type;
  std::size_t writers = 0, readers = 0;
  /// Whether all its writers offer to repeat what was lost.
  bool reliable = false;
};

/// State of a subscription.
struct DdsCounts {
  std::size_t received = 0;
  /// Messages that the writers have numbered and that were not received, or replaced before they were used.
  std::size_t lost = 0;
  /// Writers that match: none if there is no publisher, or only with another type or quality of service.
  std::size_t writers = 0;
  /// Mismatch, as a sentence: a writer of another type or of a quality that cannot be read; "" without.
  std::string trouble;
};

/// Ends with its destructor, which no callback may call: none runs after it.
class DdsSubscription {
 public:
  virtual ~DdsSubscription() = default;
  virtual DdsCounts counts() const = 0;
};

/// Ends with its destructor. Thread-safe.
class DdsPublication {
 public:
  virtual ~DdsPublication() = default;
  /// A message in CDR with its header. Throws Error: invalidInput; tooLarge beyond 256 MiB; network.
  virtual void publish(std::span<const std::byte> cdr) = 0;
  /// Readers that match now.
  virtual std::size_t readers() const = 0;
};

/// How much a writer keeps for readers that come later or miss something.
enum class Durability { volatileData, transientLocal };

/// One participant of a DDS domain. Thread-safe.
class DdsNode {
 public:
  virtual ~DdsNode() = default;
  /// Topics of other participants discovered so far; wait a second after the start.
  virtual std::vector<DdsTopic> topics() const = 0;
  /// Messages of a topic in CDR, with its header of four bytes and up to three bytes of padding at the end;
  /// `use` is called in a thread of the subscription's own. While it works, the newest messages wait: five of
  /// images, clouds and grids, two hundred of other types. Takes the reliability and durability that the
  /// writers offer: it is made anew when they differ. Throws Error (invalidInput) for names that are none.
  virtual std::unique_ptr<DdsSubscription> subscribe(
      const std::string& topic, const std::string& type,
      std::function<void(std::span<const std::byte> cdr)> use) = 0;
  /// Reliable, the last message is kept. Throws Error (invalidInput).
  virtual std::unique_ptr<DdsPublication> publish(const std::string& topic, const std::string& type,
                                                  Durability durability = Durability::volatileData) = 0;
};

/// `domain`: ROS_DOMAIN_ID. On the loopback alone with ROS_LOCALHOST_ONLY=1 in the environment, as ROS 2
/// does. Throws Error: missingDependency; invalidOption for a domain outside 0 to 232; network.
std::unique_ptr<DdsNode> makeDdsNode(int domain = 0);

}  // namespace estancia::ros
