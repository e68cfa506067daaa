// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/dds.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "support/errors.hpp"

#ifdef ESTANCIA_DDS_WRITER  // tests/CMakeLists.txt, where Fast DDS is installed
#include "ros/dds_world.hpp"
#endif

namespace estancia::ros {
namespace {

using test::FailsWith;

TEST(Dds, DomainsEndAt232) {
  EXPECT_THAT([] { makeDdsNode(-1); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([] { makeDdsNode(233); }, FailsWith(ErrorCode::invalidOption));
}

#ifndef ESTANCIA_DDS_WRITER

TEST(Dds, IsNotInEveryBuild) {
  EXPECT_THAT([] { makeDdsNode(); }, FailsWith(ErrorCode::missingDependency));
}

#else

using test::eventually;
using test::WriterProcess;

/// The numbers of the messages of a WriterProcess that arrived, and their sizes.
struct Arrivals {
  void operator()(std::span<const std::byte> cdr) {
    const std::lock_guard lock(mutex);
    bytes = cdr.size();
    if (cdr.size() >= 8) std::memcpy(&number, cdr.data() + 4, 4);
    if (count++ == 0) first = number;
  }
  std::uint32_t last() {
    const std::lock_guard lock(mutex);
    return number;
  }
  std::mutex mutex;
  std::atomic<std::size_t> count = 0, bytes = 0;
  std::uint32_t first = 0, number = 0;
};

constexpr const char* kTopic = "/camera/image_raw";
constexpr const char* kType = "sensor_msgs/Image";
/// 640 × 480 rgb8.
constexpr std::size_t imageBytes = 640 * 480 * 3 + 64;

/// A message in CDR that is distinguishable from others.
std::vector<std::byte> messageWith(unsigned char mark, std::size_t bytes = 8) {
  std::vector<std::byte> message(bytes, std::byte{mark});
  message[0] = message[2] = message[3] = std::byte{0};
  message[1] = std::byte{1};
  return message;
}

/// A node in a domain of this test.
class DdsNodes : public testing::Test {
 protected:
  const int domain_ = test::domainOfTest();
  Arrivals arrivals_;
  std::unique_ptr<DdsNode> node_ = makeDdsNode(domain_);
};

TEST_F(DdsNodes, TheReaderFitsToAllWritersThatComeAndGo) {
  const auto subscription = node_->subscribe(kTopic, kType, std::ref(arrivals_));
  WriterProcess reliable(domain_, {.bytes = 100, .hertz = 100});
  ASSERT_TRUE(eventually([&] { return arrivals_.count >= 5; }));
  WriterProcess bestEffort(domain_, {.bytes = 2000, .hertz = 100, .quality = "best-effort"});
  EXPECT_TRUE(eventually([&] { return arrivals_.bytes == 2000; }));
  EXPECT_TRUE(eventually([&] { return arrivals_.bytes == 100; }));
  EXPECT_EQ(subscription->counts().writers, 2U);
  EXPECT_EQ(subscription->counts().trouble, "");
}

TEST_F(DdsNodes, WhatAWriterKeepsForLatecomersIsReadOnce) {
  WriterProcess latched(domain_, {.topic = "rt/tf_static",
                                  .type = "tf2_msgs::msg::dds_::TFMessage_",
                                  .count = 1,
                                  .quality = "transient-local"});
  ASSERT_TRUE(eventually([&] { return !node_->topics().empty(); }));
  const auto subscription = node_->subscribe("/tf_static", "tf2_msgs/msg/TFMessage", std::ref(arrivals_));
  ASSERT_TRUE(eventually([&] { return arrivals_.count == 1; }));
  // The reader is made anew for another writer, and again as that one goes: no message comes twice.
  {
    WriterProcess live(
        domain_,
        {.topic = "rt/tf_static", .type = "tf2_msgs::msg::dds_::TFMessage_", .bytes = 500, .count = 3});
    EXPECT_EQ(live.wait(), 0);
  }
  ASSERT_TRUE(eventually([&] { return arrivals_.bytes == 500; }));
  ASSERT_TRUE(eventually([&] { return node_->topics().at(0).writers == 1; }));
  ASSERT_TRUE(eventually([&] { return subscription->counts().writers == 1; }));
  EXPECT_EQ(arrivals_.count, 4U);
}

TEST_F(DdsNodes, ATypeThatDoesNotFitIsASentence) {
  const auto subscription = node_->subscribe(kTopic, "sensor_msgs/CompressedImage", std::ref(arrivals_));
  WriterProcess writer(domain_, {});
  EXPECT_TRUE(eventually([&] { return !subscription->counts().trouble.empty(); }));
  // One that fits is read all the same.
  WriterProcess fitting(domain_, {.type = "sensor_msgs::msg::dds_::CompressedImage_"});
  EXPECT_TRUE(eventually([&] { return arrivals_.count > 0; }));
  EXPECT_EQ(subscription->counts().writers, 1U);
}

TEST_F(DdsNodes, MessagesArriveOrAreCountedAsLostAndTheNewestAreLeft) {
  const auto subscription = node_->subscribe(kTopic, kType, [&](std::span<const std::byte> cdr) {
    arrivals_(cdr);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  });
  constexpr std::uint32_t written = 500;
  WriterProcess writer(domain_, {.bytes = imageBytes, .hertz = 0, .count = written});
  EXPECT_EQ(writer.wait(), 0);
  ASSERT_TRUE(eventually([&] { return arrivals_.last() == written - 1; }));
  const DdsCounts counts = subscription->counts();
  EXPECT_EQ(counts.received + counts.lost, written - arrivals_.first);
  EXPECT_GT(counts.lost, 0U);
  EXPECT_EQ(arrivals_.bytes, imageBytes);
  EXPECT_EQ(counts.trouble, "");
}

TEST_F(DdsNodes, AWriterThatIsKilledIsTakenUpAgain) {
  const auto subscription = node_->subscribe(kTopic, kType, std::ref(arrivals_));
  for (const std::size_t bytes : {300000, 400000, 500000}) {
    WriterProcess writer(domain_, {.bytes = bytes, .quality = "reliable/udp"});
    EXPECT_TRUE(eventually([&] { return arrivals_.bytes == bytes; })) << bytes;
    writer.end(SIGKILL);
  }
  EXPECT_EQ(subscription->counts().trouble, "");
}

TEST_F(DdsNodes, AUserThatThrowsCostsTheMessage) {
  const auto subscription = node_->subscribe(kTopic, kType, [&](std::span<const std::byte> cdr) {
    arrivals_(cdr);
    throw std::runtime_error("the third eye is closed");
  });
  WriterProcess writer(domain_, {});
  EXPECT_TRUE(eventually([&] { return arrivals_.count >= 3; }));
  EXPECT_NE(subscription->counts().trouble, "");
}

TEST_F(DdsNodes, TopicsAreListedWithTheirTypesAndQuality) {
  EXPECT_TRUE(node_->topics().empty());
  WriterProcess image(domain_, {});
  WriterProcess depth(domain_, {.topic = "rt/depth", .quality = "best-effort"});
  WriterProcess both(domain_, {.topic = "rt/depth"});
  WriterProcess service(domain_, {.topic = "rq/serviceRequest"});
  WriterProcess foreign(domain_, {.topic = "Square", .type = "ShapeType"});
  const auto reading = makeDdsNode(domain_);
  const auto subscription = reading->subscribe(kTopic, kType, [](std::span<const std::byte>) {});
  ASSERT_TRUE(eventually([&] {
    const auto topics = node_->topics();
    return topics.size() == 2 && topics[0].readers == 1 && topics[0].writers == 1 && topics[1].writers == 2;
  }));
  const auto topics = node_->topics();
  EXPECT_THAT(topics[0], testing::FieldsAre(kTopic, kType, 1, 1, true));
  EXPECT_THAT(topics[1], testing::FieldsAre("/depth", kType, 2, 0, false));
}

TEST_F(DdsNodes, TheLastMapIsKeptForLatecomers) {
  const auto writing = makeDdsNode(domain_);
  const auto publication =
      writing->publish("/map_markers", "visualization_msgs/MarkerArray", Durability::transientLocal);
  for (const unsigned char mark : {1, 2, 3}) publication->publish(messageWith(mark, 3000000));
  const auto reading = makeDdsNode(domain_);
  const auto subscription =
      reading->subscribe("/map_markers", "visualization_msgs/MarkerArray", std::ref(arrivals_));
  EXPECT_TRUE(eventually([&] { return arrivals_.count > 0; }));
  EXPECT_EQ(arrivals_.last(), 0x03030303U);
  EXPECT_EQ(arrivals_.count, 1U);
}

TEST_F(DdsNodes, RefusesWhatIsNoMessageOfRos) {
  const auto ignore = [](std::span<const std::byte>) {};
  EXPECT_THAT([&] { node_->subscribe("camera", kType, ignore); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { node_->subscribe(kTopic, "Image", ignore); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { node_->publish("/a b", kType); }, FailsWith(ErrorCode::invalidInput));
  const auto publication = node_->publish(kTopic, kType);
  EXPECT_THAT([&] { node_->subscribe(kTopic, "std_msgs/String", ignore); },
              FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { publication->publish({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { publication->publish(std::vector<std::byte>(8, std::byte{9})); },
              FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { publication->publish(messageWith(0, (std::size_t{256} << 20) + 1)); },
              FailsWith(ErrorCode::tooLarge));
}

TEST_F(DdsNodes, WhatIsMadeMayEndInAnyOrder) {
  std::atomic<bool> ended = false, late = false;
  auto publication = node_->publish("/place", "std_msgs/String");
  auto other = node_->publish("/place", "std_msgs/msg/String");
  auto subscription = makeDdsNode(domain_)->subscribe(
      "/place", "std_msgs/String", [&](std::span<const std::byte>) { late = late || ended; });
  ASSERT_TRUE(eventually([&] { return publication->readers() == 1; }));
  node_.reset();
  other.reset();
  for (int i = 0; i < 200; ++i) publication->publish(messageWith(1));
  subscription.reset();
  ended = true;
  publication->publish(messageWith(2));
  publication.reset();
  EXPECT_FALSE(late);
}

#endif

}  // namespace
}  // namespace estancia::ros
