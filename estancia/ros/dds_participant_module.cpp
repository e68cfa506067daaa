// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/dds_participant_module.hpp"

#include <fastdds/rtps/common/SerializedPayload.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/PublisherQos.hpp>
#include <fastdds/dds/subscriber/qos/SubscriberQos.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/ros/dds_names.hpp"

namespace estancia::ros {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

/// With the system's buffers half of the raw images of writers that repeat nothing are lost.
constexpr std::uint32_t socketBuffer = 8U << 20;
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

class RawType final : public dds::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    // Size of a message without fields. Buffers grow with the messages.
    m_typeSize = 8;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto bytes = static_cast<const DdsSample*>(data)->out;
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    DdsSample& sample = *static_cast<DdsSample*>(data);
    sample.refused = payload->length > maxDdsBytes ? payload->length : 0;
    sample.in.resize(sample.refused > 0 ? 0 : payload->length);
    if (!sample.in.empty()) std::memcpy(sample.in.data(), payload->data, sample.in.size());
    return true;
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    const std::size_t size = static_cast<const DdsSample*>(data)->out.size();
    return [size] { return static_cast<std::uint32_t>(size); };
  }

  void* createData() override { return new DdsSample; }
  void deleteData(void* data) override { delete static_cast<DdsSample*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

/// ROS 2's own switch.
bool localhostOnly() {
  const char* value = std::getenv("ROS_LOCALHOST_ONLY");
  return value != nullptr && std::string_view(value) == "1";
}

/// UDP alone, and so other nodes write to us. Shared memory brings no image more and costs no less, but is
/// deaf for seconds to a node that was killed and comes back, and for ever to other users and versions.
void setTransports(dds::DomainParticipantQos& qos) {
  qos.transport().use_builtin_transports = false;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->sendBufferSize = udp->receiveBufferSize = socketBuffer;
  if (localhostOnly()) udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
}

/// A profile that the user names in FASTRTPS_DEFAULT_PROFILES_FILE may choose other transports.
dds::DomainParticipantQos participantQos() {
  dds::DomainParticipantFactory* factory = dds::DomainParticipantFactory::get_instance();
  // Not from the folder that the program is run in, whoever's it is.
  setenv("SKIP_DEFAULT_XML", "1", 0);
  factory->load_profiles();
  dds::DomainParticipantQos qos = factory->get_default_participant_qos();
  qos.name("estancia");
  auto& builtin = qos.wire_protocol().builtin;
  // Announcements may be larger than the buffers that they begin with.
  builtin.readerHistoryMemoryPolicy = builtin.writerHistoryMemoryPolicy =
      rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  if (qos.transport().use_builtin_transports && qos.transport().user_transports.empty()) setTransports(qos);
  return qos;
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

DdsParticipant::DdsParticipant(int domain) {
  dds::DomainParticipantFactory* factory = dds::DomainParticipantFactory::get_instance();
  // The participant reports discovery only; everything else is reported to readers and writers.
  participant_ = factory->create_participant(static_cast<std::uint32_t>(domain), participantQos(), &graph_,
                                             dds::StatusMask::none());
  if (participant_ != nullptr) {
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  if (publisher_ == nullptr || subscriber_ == nullptr) {
    end();
    fail(ErrorCode::network,
         "domain {} of ROS 2 cannot be joined; see that a network interface is up and its UDP ports are free",
         domain);
  }
}

DdsParticipant::~DdsParticipant() {
  end();
}

void DdsParticipant::end() {
  if (participant_ == nullptr) return;
  participant_->set_listener(nullptr);
  participant_->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

dds::Topic* DdsParticipant::acquire(const std::string& topic, const std::string& type) {
  const std::string ddsTopic = ddsTopicName(topic), ddsType = ddsTypeName(type);
  const std::lock_guard lock(mutex_);
  for (auto& [known, users] : users_)
    if (known->get_name() == ddsTopic) {
      if (known->get_type_name() != ddsType)
        fail(ErrorCode::invalidInput, "{} is used as {} already; use it as {} in a node of its own", topic,
             rosTypeName(known->get_type_name()), type);
      ++users;
      return known;
    }
  auto& support = types_[ddsType];
  if (support.empty()) support = dds::TypeSupport(new RawType(ddsType));
  dds::Topic* made = nullptr;
  if (participant_->register_type(support) == ReturnCode_t::RETCODE_OK)
    made = participant_->create_topic(ddsTopic, ddsType, dds::TOPIC_QOS_DEFAULT);
  if (made == nullptr)
    fail(ErrorCode::invalidInput, "DDS refuses the topic {} of {}; choose another", topic, type);
  users_.emplace(made, 1);
  return made;
}

void DdsParticipant::release(dds::Topic* topic) {
  const std::lock_guard lock(mutex_);
  const auto found = users_.find(topic);
  if (found == users_.end() || --found->second > 0) return;
  users_.erase(found);
  participant_->delete_topic(topic);
}

}  // namespace estancia::ros
