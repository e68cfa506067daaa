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

#include "estancia/core/fail.hpp"
#include "estancia/ros/dds_names.hpp"

namespace estancia::ros {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

/// With the system's buffers half of the raw images of writers that repeat nothing are lost.
constexpr std::uint32_t socketBuffer = 8U << 20;
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
/// deaf for seconds to a node that was killed and comes back, and for ever to nodes of other users,
/// containers or versions.
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
