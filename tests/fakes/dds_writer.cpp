// A writer of DDS that stands for a node of ROS 2: the settings of rmw_fastrtps in Humble, and nothing of
// Estancia.
//   dds_writer domain topic type bytes hertz count quality
// Waits for a reader, then writes `count` messages (0: until SIGTERM) of `bytes` bytes, `hertz` a second
// (0: as fast as it can). A message is a header of CDR, its number, and zeros. `quality` is reliable,
// best-effort or transient-local; with /udp behind it, without shared memory, of which a killed process
// leaves something behind. SPDX-License-Identifier: Apache-2.0
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <signal.h>
#include <sys/prctl.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/publisher/qos/PublisherQos.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Bytes = std::vector<unsigned char>;

class BytesType final : public fast::TopicDataType {
 public:
  explicit BytesType(const char* name) {
    setName(name);
    m_typeSize = 8;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<const Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

/// Where ROS_LOCALHOST_ONLY is not 1, what Fast DDS does by itself.
fast::DomainParticipantQos localParticipant(bool sharesMemory) {
  fast::DomainParticipantQos qos;
  const char* local = std::getenv("ROS_LOCALHOST_ONLY");
  const bool isLocal = local != nullptr && std::string(local) == "1";
  if (!isLocal && sharesMemory) return qos;
  qos.transport().use_builtin_transports = false;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  if (isLocal) udp->interfaceWhiteList.push_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  if (sharesMemory)
    qos.transport().user_transports.push_back(
        std::make_shared<eprosima::fastdds::rtps::SharedMemTransportDescriptor>());
  return qos;
}

fast::DataWriterQos writerQos(const std::string& quality) {
  fast::DataWriterQos qos;
  const bool reliable = quality != "best-effort";
  qos.reliability().kind = reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind =
      quality == "transient-local" ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = reliable ? 10 : 5;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
  return qos;
}

volatile sig_atomic_t ended = 0;

bool hasReader(fast::DataWriter& writer) {
  fast::PublicationMatchedStatus status;
  writer.get_publication_matched_status(status);
  return status.current_count > 0;
}

}  // namespace

int main(int count, char** words) {
  if (count != 8) return 2;
  signal(SIGTERM, [](int) { ended = 1; });
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that fails leaves no writer behind
  const std::string topicName = words[2], typeName = words[3];
  std::string quality = words[7];
  const bool remote = quality.ends_with("/udp");
  if (remote) quality.resize(quality.size() - 4);
  const auto size = static_cast<std::size_t>(std::atoll(words[4]));
  const double hertz = std::atof(words[5]);
  const long long messages = std::atoll(words[6]);

  auto* factory = fast::DomainParticipantFactory::get_instance();
  auto* participant =
      factory->create_participant(static_cast<std::uint32_t>(std::atoi(words[1])), localParticipant(!remote));
  if (participant == nullptr) return 3;
  fast::TypeSupport type(new BytesType(typeName.c_str()));
  type.register_type(participant);
  auto* topic = participant->create_topic(topicName, typeName, fast::TOPIC_QOS_DEFAULT);
  auto* writer = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
                     ->create_datawriter(topic, writerQos(quality));
  if (writer == nullptr) return 4;

  Bytes bytes(size, 0);
  if (size > 1) bytes[1] = 1;
  while (ended == 0 && quality != "transient-local" && !hasReader(*writer))
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::puts("writing");
  std::fflush(stdout);
  auto next = std::chrono::steady_clock::now();
  for (std::uint32_t i = 0; ended == 0 && (messages == 0 || i < messages); ++i) {
    if (size >= 8) std::memcpy(bytes.data() + 4, &i, 4);
    writer->write(&bytes);
    if (hertz <= 0) continue;
    next += std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / hertz));
    std::this_thread::sleep_until(next);
  }
  // A latched message is there as long as the test wants it.
  while (ended == 0 && quality == "transient-local")
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (ended == 0) writer->wait_for_acknowledgments({10, 0});
  participant->delete_contained_entities();
  factory->delete_participant(participant);
}
