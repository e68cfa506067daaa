// The module with Fast DDS; dds.cpp opens it.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/ros/dds_names.hpp"
#include "estancia/ros/dds_participant_module.hpp"

namespace estancia::ros {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

/// ROS 2's own default.
constexpr std::int32_t writerDepth = 10;
/// Messages that wait while one is used; older ones make room.
constexpr std::int32_t fewLarge = 5, manySmall = 200;
/// Writers that a subscription remembers.
constexpr std::size_t maxRemembered = 1000;

std::int32_t depthFor(const std::string& type) {
  constexpr std::array<std::string_view, 4> large{"sensor_msgs/Image", "sensor_msgs/CompressedImage",
                                                  "sensor_msgs/PointCloud2", "nav_msgs/OccupancyGrid"};
  return std::find(large.begin(), large.end(), type) != large.end() ? fewLarge : manySmall;
}

/// Quality of service of a reader or a writer.
template <class Qos>
Qos qosOf(const DdsQuality& quality, std::int32_t depth) {
  Qos qos;
  qos.reliability().kind =
      quality.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind =
      quality.transientLocal ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  qos.resource_limits().allocated_samples = 1;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  // ROS 2's writers do not share their data.
  qos.data_sharing().off();
  return qos;
}

/// Counts numbered messages that were not received; recognizes those that come again to a new reader.
class SequenceNumbers {
 public:
  /// Whether the message is new.
  bool count(const rtps::SampleIdentity& sample, std::size_t& lost) {
    if (last_.size() >= maxRemembered) last_.clear();
    const std::int64_t number = sample.sequence_number().to64long();
    const auto [found, isFirst] = last_.try_emplace(sample.writer_guid(), number);
    if (isFirst) return true;
    if (number <= found->second) return false;
    lost += static_cast<std::size_t>(number - found->second - 1);
    found->second = number;
    return true;
  }

 private:
  std::map<rtps::GUID_t, std::int64_t> last_;
};

/// Its own thread makes the reader and takes from it, so that `use` keeps no thread of DDS from receiving.
/// Invariant: `mutex_` guards flags, counts and the offer; `reader_` and `sample_` belong to the thread
/// alone. Life cycle: the reader is made when a writer offers the type, again when its quality changes, and
/// is deleted by the thread when the subscription ends.
class Subscription final : public DdsSubscription, private dds::DataReaderListener {
 public:
  Subscription(std::shared_ptr<DdsParticipant> participant, const std::string& topic, const std::string& type,
               std::function<void(std::span<const std::byte>)> use)
      : participant_(std::move(participant)),
        topic_(topic),
        type_(rosTypeName(ddsTypeName(type))),
        use_(std::move(use)),
        ddsTopic_(participant_->acquire(topic, type)) {
    watch_ = participant_->graph().watch(topic_, [this] { wake(changed_); });
    thread_ = std::thread([this] { run(); });
  }

  ~Subscription() override {
    participant_->graph().unwatch(watch_);
    wake(ending_);
    thread_.join();
    participant_->release(ddsTopic_);
  }

  DdsCounts counts() const override {
    const DdsOffer offer = participant_->graph().offer(topic_, type_);
    const std::lock_guard lock(mutex_);
    DdsCounts counts = counts_;
    if (!offer.otherType.empty())
      counts.trouble = fmt::format("{} is also published as {}, which is not {}; such messages are not read",
                                   topic_, offer.otherType, type_);
    else if (!offer.obstacle.empty())
      counts.trouble = fmt::format("a writer of {} asks for {}, which is not read", topic_, offer.obstacle);
    return counts;
  }

 private:
  void wake(bool& why) {
    {
      const std::lock_guard lock(mutex_);
      why = true;
    }
    wakened_.notify_one();
  }

  void on_data_available(dds::DataReader*) override { wake(arrived_); }

  void on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) override {
    const std::lock_guard lock(mutex_);
    counts_.writers = static_cast<std::size_t>(std::max(status.current_count, 0));
  }

  void run() {
    for (std::unique_lock lock(mutex_);;) {
      wakened_.wait(lock, [this] { return changed_ || arrived_ || ending_; });
      if (ending_) break;
      const bool changed = std::exchange(changed_, false);
      arrived_ = false;
      lock.unlock();
      if (changed) fit();
      take();
      lock.lock();
    }
    endReader();
  }

  /// A reader that fits to all writers. It stays when they go, as they may come back.
  void fit() {
    const DdsOffer offer = participant_->graph().offer(topic_, type_);
    if (offer.writers == 0 || quality_ == offer.quality) return;
    endReader();
    reader_ = participant_->subscriber().create_datareader(
        ddsTopic_, qosOf<dds::DataReaderQos>(offer.quality, depthFor(type_)), this);
    if (reader_ != nullptr)
      quality_ = offer.quality;
    else
      setTrouble(fmt::format("DDS gives no reader of {}; start again", topic_));
  }

  void endReader() {
    if (reader_ == nullptr) return;
    reader_->set_listener(nullptr);
    participant_->subscriber().delete_datareader(reader_);
    reader_ = nullptr;
    quality_.reset();
    const std::lock_guard lock(mutex_);
    counts_.writers = 0;
  }

  void take() {
    while (reader_ != nullptr && !interrupted()) {
      dds::SampleInfo info;
      const ReturnCode_t taken = reader_->take_next_sample(&sample_, &info);
      if (taken == ReturnCode_t::RETCODE_TIMEOUT) continue;
      if (taken != ReturnCode_t::RETCODE_OK) return;
      if (info.valid_data) give(info.sample_identity);
    }
  }

  bool interrupted() const {
    const std::lock_guard lock(mutex_);
    return ending_ || changed_;
  }

  void give(const rtps::SampleIdentity& identity) {
    {
      const std::lock_guard lock(mutex_);
      if (!numbers_.count(identity, counts_.lost)) return;
      ++(sample_.refused > 0 ? counts_.lost : counts_.received);
    }
    if (sample_.refused > 0)
      return setTrouble(fmt::format("a message of {} has {} bytes, at most {} are read", topic_,
                                    sample_.refused, maxDdsBytes));
    try {
      use_(sample_.in);
    } catch (const std::exception& failure) {
      setTrouble(fmt::format("a message of {} was not used: {}", topic_, failure.what()));
    }
  }

  void setTrouble(std::string sentence) {
    const std::lock_guard lock(mutex_);
    counts_.trouble = std::move(sentence);
  }

  const std::shared_ptr<DdsParticipant> participant_;
  const std::string topic_, type_;
  const std::function<void(std::span<const std::byte>)> use_;
  dds::Topic* const ddsTopic_;
  std::size_t watch_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable wakened_;
  // Writers may be known already.
  bool changed_ = true, arrived_ = false, ending_ = false;
  DdsCounts counts_;
  SequenceNumbers numbers_;

  // Used by the thread only.
  dds::DataReader* reader_ = nullptr;
  std::optional<DdsQuality> quality_;
  DdsSample sample_;
  std::thread thread_;
};

class Publication final : public DdsPublication {
 public:
  Publication(std::shared_ptr<DdsParticipant> participant, const std::string& topic, const std::string& type,
              Durability durability)
      : participant_(std::move(participant)), topic_(topic), ddsTopic_(participant_->acquire(topic, type)) {
    const bool isKept = durability == Durability::transientLocal;
    auto qos = qosOf<dds::DataWriterQos>({true, isKept}, isKept ? 1 : writerDepth);
    // Publishing does not wait for the network.
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
    writer_ = participant_->publisher().create_datawriter(ddsTopic_, qos);
    if (writer_ == nullptr) {
      participant_->release(ddsTopic_);
      fail(ErrorCode::invalidInput, "DDS gives no writer of {}; choose another topic", topic);
    }
  }

  ~Publication() override {
    participant_->publisher().delete_datawriter(writer_);
    participant_->release(ddsTopic_);
  }

  void publish(std::span<const std::byte> cdr) override {
    if (cdr.size() > maxDdsBytes)
      fail(ErrorCode::tooLarge, "a message of {} has {} bytes, at most {} are published", topic_, cdr.size(),
           maxDdsBytes);
    if (cdr.size() < 4 || cdr[0] != std::byte{0} || cdr[1] > std::byte{1})
      fail(ErrorCode::invalidInput, "a message of {} does not begin with the header of CDR; write it by CDR",
           topic_);
    DdsSample sample;
    sample.out = cdr;
    if (!writer_->write(&sample))
      fail(ErrorCode::network, "a message of {} could not be published; try again", topic_);
  }

  std::size_t readers() const override {
    dds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return static_cast<std::size_t>(std::max(status.current_count, 0));
  }

 private:
  const std::shared_ptr<DdsParticipant> participant_;
  const std::string topic_;
  dds::Topic* const ddsTopic_;
  dds::DataWriter* writer_ = nullptr;
};

class Node final : public DdsNode {
 public:
  explicit Node(int domain) : participant_(std::make_shared<DdsParticipant>(domain)) {}

  std::vector<DdsTopic> topics() const override { return participant_->graph().topics(); }

  std::unique_ptr<DdsSubscription> subscribe(const std::string& topic, const std::string& type,
                                             std::function<void(std::span<const std::byte>)> use) override {
    return std::make_unique<Subscription>(participant_, topic, type, std::move(use));
  }

  std::unique_ptr<DdsPublication> publish(const std::string& topic, const std::string& type,
                                          Durability durability) override {
    return std::make_unique<Publication>(participant_, topic, type, durability);
  }

 private:
  const std::shared_ptr<DdsParticipant> participant_;
};

}  // namespace
}  // namespace estancia::ros

extern "C" __attribute__((visibility("default"))) estancia::ros::DdsNode* estanciaMakeDdsNode(int domain) {
  return new estancia::ros::Node(domain);
}
