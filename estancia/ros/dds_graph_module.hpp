// DDS discovery: which writers and readers of ROS topics other participants have; a part of the module.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastdds/rtps/common/Guid.h>
#include <cstddef>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <functional>
#include <map>
#include <mutex>
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

}  // namespace estancia::ros
