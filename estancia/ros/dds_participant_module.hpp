// DDS participant: one member of a domain, its topics, and what others have there; a part of the module.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/rtps/common/Guid.h>
#include <cstddef>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "estancia/ros/dds.hpp"

namespace estancia::ros {

/// Requirements of a reader for its writers.
struct DdsQuality {
  bool reliable = true, transientLocal = false;
  bool operator==(const DdsQuality&) const = default;
};

/// Other participants' writers of one topic.
struct DdsOffer {
  /// Writers of the type.
  std::size_t writers = 0;
  /// Qualities that all of these offer.
  DdsQuality quality;
  /// Type of one writer of another type; "" where there are none.
  std::string otherType;
  /// The quality of a writer of the type that no reader here matches; "" if there is none.
  std::string obstacle;
};

/// Thread-safe. Calls nothing of DDS, so that its callbacks cannot wait for each other.
class DdsGraph final : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  std::vector<DdsTopic> topics() const;
  /// `type` as ROS writes it.
  DdsOffer offer(const std::string& topic, const std::string& type) const;
  /// `changed` is called, in a thread of DDS, after each change of the topic's writers, until unwatch(key).
  std::size_t watch(const std::string& topic, std::function<void()> changed);
  void unwatch(std::size_t key);

 private:
  using Guid = eprosima::fastrtps::rtps::GUID_t;
  struct Endpoint {
    /// Topic and type by their ROS names; the type is "" where it is none of ROS.
    std::string topic, type;
    bool isWriter = false;
    DdsQuality quality;
    std::string obstacle;
  };
  struct Watch {
    std::string topic;
    std::function<void()> changed;
  };

  void on_participant_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                                eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& info) override;
  void on_subscriber_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                               eprosima::fastrtps::rtps::ReaderDiscoveryInfo&& info) override;
  void on_publisher_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                              eprosima::fastrtps::rtps::WriterDiscoveryInfo&& info) override;
  void put(const Guid& guid, Endpoint endpoint);
  void remove(const Guid& guid);
  void tell(const std::string& topic) const;

  mutable std::mutex mutex_;
  std::map<Guid, Endpoint> endpoints_;
  std::map<std::size_t, Watch> watches_;
  std::size_t nextKey_ = 0;
};

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

/// A member with sockets large enough for images; lives as long as what it was used for. Thread-safe.
/// Invariant: a topic exists as long as somebody has acquired it, counted in `users_`; `mutex_` guards topics
/// and types. Life cycle: the destructor deletes everything of DDS, so all users must be gone by then.
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
