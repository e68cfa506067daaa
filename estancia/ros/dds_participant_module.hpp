// DDS participant: one member of a domain with sockets that are large enough for images, and its topics; a
// part of the module. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "estancia/ros/dds_graph_module.hpp"

namespace estancia::ros {

/// Larger messages are neither read nor written.
inline constexpr std::size_t maxDdsBytes = std::size_t{256} << 20;

/// A sample of every type: the message in CDR with its header, as it is.
struct DdsSample {
  /// To write.
  std::span<const std::byte> out;
  /// Result of reading.
  std::vector<std::byte> in;
  /// Size of a message that was refused as too large; else 0 [bytes].
  std::size_t refused = 0;
};

/// Lives as long as what it was used for. Thread-safe.
class DdsParticipant {
 public:
  /// Throws Error (network).
  explicit DdsParticipant(int domain);
  ~DdsParticipant();
  DdsParticipant(const DdsParticipant&) = delete;
  DdsParticipant& operator=(const DdsParticipant&) = delete;

  /// Names as ROS writes them; each call asks for one release. Throws Error (invalidInput).
  eprosima::fastdds::dds::Topic* acquire(const std::string& topic, const std::string& type);
  void release(eprosima::fastdds::dds::Topic* topic);

  DdsGraph& graph() { return graph_; }
  eprosima::fastdds::dds::Publisher& publisher() { return *publisher_; }
  eprosima::fastdds::dds::Subscriber& subscriber() { return *subscriber_; }

 private:
  void end();

  DdsGraph graph_;
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::Subscriber* subscriber_ = nullptr;
  std::mutex mutex_;
  std::map<std::string, eprosima::fastdds::dds::TypeSupport> types_;
  std::map<eprosima::fastdds::dds::Topic*, std::size_t> users_;
};

}  // namespace estancia::ros
