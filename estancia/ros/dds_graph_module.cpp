// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/dds_graph_module.hpp"

#include <utility>

#include "estancia/ros/dds_names.hpp"

namespace estancia::ros {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

/// Whoever is on the network can announce as many as it likes.
constexpr std::size_t maxEndpoints = 20000;

/// Data of both kinds of announcements.
template <class Announced>
DdsQuality qualityOf(const Announced& announced) {
  return {announced.m_qos.m_reliability.kind == dds::RELIABLE_RELIABILITY_QOS,
          announced.m_qos.m_durability.kind != dds::VOLATILE_DURABILITY_QOS};
}

std::string obstacleOf(const rtps::WriterProxyData& writer) {
  if (writer.m_qos.m_ownership.kind != dds::SHARED_OWNERSHIP_QOS) return "exclusive ownership";
  if (writer.m_qos.m_partition.size() > 0) return "a partition";
  return writer.topicKind() == rtps::WITH_KEY ? "keys" : "";
}

}  // namespace

std::vector<DdsTopic> DdsGraph::topics() const {
  const std::lock_guard lock(mutex_);
  std::map<std::pair<std::string, std::string>, DdsTopic> found;
  for (const auto& [guid, endpoint] : endpoints_) {
    if (endpoint.type.empty()) continue;
    DdsTopic& topic = found[{endpoint.topic, endpoint.type}];
    topic.name = endpoint.topic;
    topic.type = endpoint.type;
    if (endpoint.isWriter)
      topic.reliable = (topic.writers == 0 || topic.reliable) && endpoint.quality.reliable;
    ++(endpoint.isWriter ? topic.writers : topic.readers);
  }
  std::vector<DdsTopic> topics;
  topics.reserve(found.size());
  for (auto& [key, topic] : found) topics.push_back(std::move(topic));
  return topics;
}

DdsOffer DdsGraph::offer(const std::string& topic, const std::string& type) const {
  const std::lock_guard lock(mutex_);
  DdsOffer offer;
  for (const auto& [guid, endpoint] : endpoints_) {
    if (!endpoint.isWriter || endpoint.topic != topic) continue;
    if (endpoint.type != type) {
      offer.otherType = endpoint.type.empty() ? "a type that is none of ROS" : endpoint.type;
    } else if (!endpoint.obstacle.empty()) {
      offer.obstacle = endpoint.obstacle;
    } else {
      const bool first = offer.writers++ == 0;
      offer.quality.reliable = (first || offer.quality.reliable) && endpoint.quality.reliable;
      offer.quality.transientLocal =
          (first || offer.quality.transientLocal) && endpoint.quality.transientLocal;
    }
  }
  return offer;
}

std::size_t DdsGraph::watch(const std::string& topic, std::function<void()> changed) {
  const std::lock_guard lock(mutex_);
  watches_.emplace(nextKey_, Watch{topic, std::move(changed)});
  return nextKey_++;
}

void DdsGraph::unwatch(std::size_t key) {
  const std::lock_guard lock(mutex_);
  watches_.erase(key);
}

// A participant that goes or is lost takes its endpoints along; not every one of them is announced then.
void DdsGraph::on_participant_discovery(dds::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& info) {
  if (info.status != rtps::ParticipantDiscoveryInfo::REMOVED_PARTICIPANT &&
      info.status != rtps::ParticipantDiscoveryInfo::DROPPED_PARTICIPANT)
    return;
  const std::lock_guard lock(mutex_);
  std::erase_if(endpoints_,
                [&](const auto& entry) { return entry.first.guidPrefix == info.info.m_guid.guidPrefix; });
  for (const auto& [key, watch] : watches_) watch.changed();
}

void DdsGraph::on_subscriber_discovery(dds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) {
  if (info.status == rtps::ReaderDiscoveryInfo::REMOVED_READER) return remove(info.info.guid());
  put(info.info.guid(), {rosTopicName(info.info.topicName().to_string()),
                         rosTypeName(info.info.typeName().to_string()), false, qualityOf(info.info), ""});
}

void DdsGraph::on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) {
  if (info.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER) return remove(info.info.guid());
  put(info.info.guid(),
      {rosTopicName(info.info.topicName().to_string()), rosTypeName(info.info.typeName().to_string()), true,
       qualityOf(info.info), obstacleOf(info.info)});
}

void DdsGraph::put(const Guid& guid, Endpoint endpoint) {
  if (endpoint.topic.empty()) return;
  const std::lock_guard lock(mutex_);
  if (endpoints_.size() >= maxEndpoints && !endpoints_.contains(guid)) return;
  const std::string topic = endpoint.topic;
  endpoints_.insert_or_assign(guid, std::move(endpoint));
  tell(topic);
}

void DdsGraph::remove(const Guid& guid) {
  const std::lock_guard lock(mutex_);
  const auto found = endpoints_.find(guid);
  if (found == endpoints_.end()) return;
  const std::string topic = found->second.topic;
  endpoints_.erase(found);
  tell(topic);
}

void DdsGraph::tell(const std::string& topic) const {
  for (const auto& [key, watch] : watches_)
    if (watch.topic == topic) watch.changed();
}

}  // namespace estancia::ros
