// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/published_messages.hpp"
#include "estancia/ros/transform_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>

#include "estancia/core/pose.hpp"
#include "estancia/ros/dds_names.hpp"
#include "estancia/ros/messages.hpp"
#include "estancia/ros/wire.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

using test::FailsWith;

std::vector<std::byte> wireBytes(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST(WireReader, Ros1IsPackedAndItsStringsHaveNoZero) {
  const auto bytes = wireBytes({1, 2, 0, 0, 0, 'o', 'k', 0, 0, 0x80, 0x3f});
  WireReader reader(bytes, Encoding::ros1);
  EXPECT_EQ(reader.number<std::uint8_t>(), 1);
  EXPECT_EQ(reader.text(), "ok");
  EXPECT_EQ(reader.number<float>(), 1.0F);
}

TEST(WireReader, CdrIsAlignedFromBehindItsHeader) {
  // After the header: a byte, three of padding, a number, then one of 8 bytes at 8.
  const auto bytes = wireBytes({0, 1, 0, 0, 7, 0, 0, 0, 4, 3, 2, 1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f});
  WireReader reader(bytes, Encoding::cdr);
  EXPECT_EQ(reader.number<std::uint8_t>(), 7);
  EXPECT_EQ(reader.number<std::uint32_t>(), 0x01020304U);
  EXPECT_EQ(reader.number<double>(), 1.0);
}

TEST(WireReader, BigEndianCdrAndTheSecondVersionAreRead) {
  const auto big = wireBytes({0, 0, 0, 0, 1, 2, 3, 4});
  EXPECT_EQ(WireReader(big, Encoding::cdr).number<std::uint32_t>(), 0x01020304U);
  // XCDR2 aligns numbers of eight bytes to four.
  const auto second = wireBytes({0, 7, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f});
  WireReader reader(second, Encoding::cdr);
  reader.number<std::uint8_t>();
  EXPECT_EQ(reader.number<double>(), 1.0);
}

TEST(WireReader, WhatIsNoMessageIsRefused) {
  const auto parameterList = wireBytes({0, 3, 0, 0, 1, 2, 3, 4}), few = wireBytes({0, 1, 0, 0, 1, 2}),
             huge = wireBytes({0xff, 0xff, 0xff, 0xff, 1, 2, 3, 4});
  EXPECT_THAT([&] { WireReader(parameterList, Encoding::cdr); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { WireReader(few, Encoding::cdr).number<std::uint32_t>(); },
              FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT([&] { WireReader(wireBytes({0, 1}), Encoding::cdr); }, FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT([&] { WireReader(huge, Encoding::ros1).numbers<double>(); },
              FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT([&] { WireReader(huge, Encoding::ros1).text(); }, FailsWith(ErrorCode::truncatedFile));
}

TEST(Messages, EveryTruncationOfAMessageIsAnError) {
  // A header of ROS 1, 2 × 1 pixels in mono8.
  const auto whole =
      wireBytes({5, 0, 0, 0, 1, 0, 0, 0, 2,   0,   0,   0,   4,   0, 0, 0, '/', 'c', 'a', 'm', 1, 0, 0, 0,
                 2, 0, 0, 0, 5, 0, 0, 0, 'm', 'o', 'n', 'o', '8', 0, 2, 0, 0,   0,   2,   0,   0, 0, 7, 8});
  const ImageMessage image = readImageMessage({whole, Encoding::ros1});
  EXPECT_EQ(image.header.stamp, 1'000'000'002);
  EXPECT_EQ(image.header.frame, "cam");
  EXPECT_EQ(image.encoding, "mono8");
  EXPECT_EQ(image.data.size(), 2U);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THAT(
        [&] {
          readImageMessage({std::span(whole).first(size), Encoding::ros1});
        },
        FailsWith(ErrorCode::truncatedFile))
        << size;
}

TEST(Messages, AnotherTypeIsNoPose) {
  EXPECT_FALSE(isPoseType("sensor_msgs/Image"));
  EXPECT_THAT([] { readPoses({}, "sensor_msgs/Image"); }, FailsWith(ErrorCode::unknownName));
}

std::string textOf(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<std::byte> rgbOfTwoRows() {
  std::vector<std::byte> data;
  for (int i = 0; i < 18; ++i) data.push_back(static_cast<std::byte>(10 * i));
  return data;
}

/// What tests/ros/write_messages.js writes.
std::vector<Marker> markersOfAMap() {
  std::vector<Marker> markers(3);
  Marker& path = markers[0];
  path.stamp = 12'500'000'000;
  path.frame = "odom";
  path.space = "places";
  path.id = 7;
  path.type = Marker::Type::lineStrip;
  path.position = {1.5, -2, 0.25};
  path.orientation = {0, 0, 1, 0};
  path.scale = {0.05, 0, 0};
  path.color = {1, 0.5F, 0.25F, 0.75F};
  path.lifetime = 2'000'000'001;
  path.frameLocked = true;
  path.points = {{1, 2, 3}, {-1, 0.5, 1e-3}};
  path.colors = {{1, 0, 0, 1}, {0, 1, 0, 0.5F}};
  markers[1].space = "names";
  markers[1].id = -1;
  markers[1].type = Marker::Type::text;
  markers[1].text = "kitchen";
  markers[1].scale = {1, 1, 0.3};
  markers[2].action = Marker::Action::removeAll;
  return markers;
}

TEST(PublishedMessages, AreByteForByteThoseOfAnotherWriter) {
  const auto modules = test::findFetched("test-tools/node_modules");
  ESTANCIA_NEEDS(modules, "the tests' npm packages are missing; run script/bootstrap");
  const test::ScratchFolder folder;
  const auto written = test::runProgram(
      "node", {std::string(ESTANCIA_SOURCE_DIR) + "/tests/ros/write_messages.js", *modules, folder.path()});
  ASSERT_EQ(written.exitCode, 0) << written.err;
  EXPECT_EQ(textOf(stringMessage("kitchen")), test::readFile(folder / "string"));
  EXPECT_EQ(textOf(imageMessage(1'700'000'000'123'456'789, "camera", 3, 2, "rgb8", rgbOfTwoRows())),
            test::readFile(folder / "image"));
  EXPECT_EQ(textOf(markerArrayMessage(markersOfAMap())), test::readFile(folder / "markers"));
}

TEST(PublishedMessages, RefuseWhatNobodyCouldDraw) {
  std::vector<Marker> markers = markersOfAMap();
  markers[0].colors.pop_back();
  EXPECT_THAT([&] { markerArrayMessage(markers); }, FailsWith(ErrorCode::invalidInput));
  const auto data = rgbOfTwoRows();
  EXPECT_THAT([&] { imageMessage(0, "", 3, 4, "rgb8", data); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { imageMessage(0, "", 3, 0, "rgb8", data); }, FailsWith(ErrorCode::invalidInput));
}

TEST(CdrWriter, TimesBeforeTheEpochAndBeyondItsEndAreTheNearest) {
  const auto time = [](std::int64_t nanoseconds) {
    CdrWriter cdr;
    cdr.putTime(nanoseconds);
    const auto bytes = cdr.take();
    std::pair<std::int32_t, std::uint32_t> read;
    std::memcpy(&read.first, bytes.data() + 4, 4);
    std::memcpy(&read.second, bytes.data() + 8, 4);
    return read;
  };
  using Time = std::pair<std::int32_t, std::uint32_t>;
  EXPECT_EQ(time(1), Time(0, 1U));
  EXPECT_EQ(time(-1), Time(-1, 999'999'999U));
  EXPECT_EQ(time(-1'000'000'000), Time(-1, 0U));
  EXPECT_EQ(time(std::numeric_limits<std::int64_t>::max()), Time(0x7FFFFFFF, 999'999'999U));
  EXPECT_EQ(time(std::numeric_limits<std::int64_t>::min()), Time(-0x7FFFFFFF - 1, 0U));
}

TEST(DdsNames, AreThoseOfRos2) {
  EXPECT_EQ(ddsTopicName("/camera/image_raw"), "rt/camera/image_raw");
  EXPECT_EQ(rosTopicName("rt/camera/image_raw"), "/camera/image_raw");
  EXPECT_EQ(ddsTypeName("sensor_msgs/Image"), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(ddsTypeName("sensor_msgs/msg/Image"), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(ddsTypeName("tf2_msgs/action/Look_Feedback"), "tf2_msgs::action::dds_::Look_Feedback_");
  EXPECT_EQ(rosTypeName("sensor_msgs::msg::dds_::Image_"), "sensor_msgs/Image");
  EXPECT_EQ(rosTypeName("tf2_msgs::action::dds_::Look_Feedback_"), "tf2_msgs/action/Look_Feedback");
}

TEST(DdsNames, WhatIsNotOfRosHasNone) {
  for (const char* topic : {"", "rt", "rt/", "rq/service", "HelloTopic", "rt/a b", "rt//a", "rt/a/", "rt/1a",
                            "rt/a\x1b[31m", "rt\0/a"})
    EXPECT_EQ(rosTopicName(topic), "") << topic;
  for (const char* type :
       {"", "HelloWorld", "a::msg::B_", "a::msg::dds_::B", "a::msg::dds_::_", "::msg::dds_::B_",
        "a::idl::dds_::B_", "a::msg::dds_::B\n_", "a::msg::dds_::B_::C_"})
    EXPECT_EQ(rosTypeName(type), "") << type;
}

TEST(DdsNames, RefusesWhatRosWouldRefuse) {
  for (const char* topic : {"", "/", "camera", "/camera/", "//camera", "/cam era", "/1st", "/a-b"})
    EXPECT_THAT([&] { ddsTopicName(topic); }, FailsWith(ErrorCode::invalidInput)) << topic;
  EXPECT_THAT([] { ddsTopicName("/" + std::string(300, 'a')); }, FailsWith(ErrorCode::invalidInput));
  for (const char* type :
       {"", "Image", "sensor_msgs/", "/Image", "a/b/C", "a/msg/b/C", "a/B;C", "sensor_msgs::Image"})
    EXPECT_THAT([&] { ddsTypeName(type); }, FailsWith(ErrorCode::invalidInput)) << type;
}

constexpr std::int64_t ms = 1'000'000;

StampedPose transformAt(std::int64_t time, const char* parent, const char* child, double x, double yaw = 0) {
  return {{time, parent}, child, {x, 0, 0, 0, 0, std::sin(yaw / 2), std::cos(yaw / 2)}};
}

TransformTree robot() {
  TransformTree tree(500 * ms, 50 * ms);
  tree.add(transformAt(0, "base", "camera", 0.5), true);
  tree.add(transformAt(0, "odom", "base", 0), false);
  tree.add(transformAt(100 * ms, "odom", "base", 1, M_PI / 2), false);
  tree.add(transformAt(0, "map", "odom", 10), true);
  return tree;
}

TEST(TransformTree, ChainsAreInterpolatedInTime) {
  const TransformTree tree = robot();
  EXPECT_EQ(tree.rootOf("camera"), "map");
  EXPECT_TRUE(tree.isMoving("camera"));
  EXPECT_FALSE(tree.isMoving("odom"));
  const auto camera = tree.find("map", "camera", 50 * ms);
  ASSERT_TRUE(camera);
  EXPECT_NEAR(angleOf(*camera), M_PI / 4, 1e-12);
  EXPECT_NEAR(camera->translation()[0], 10 + 0.5 + 0.5 * std::cos(M_PI / 4), 1e-12);
  EXPECT_NEAR(camera->translation()[1], 0.5 * std::sin(M_PI / 4), 1e-12);
}

TEST(TransformTree, TheInverseIsFoundToo) {
  const TransformTree tree = robot();
  const auto there = tree.find("map", "camera", 50 * ms), back = tree.find("camera", "map", 50 * ms);
  ASSERT_TRUE(there && back);
  EXPECT_LT(cv::norm((*there * *back).matrix - cv::Affine3d::Identity().matrix), 1e-12);
}

TEST(TransformTree, ATransformHoldsForAShortTimeOnly) {
  const TransformTree tree = robot();
  EXPECT_TRUE(tree.find("odom", "base", 140 * ms));
  EXPECT_FALSE(tree.find("odom", "base", 160 * ms));
  EXPECT_TRUE(tree.find("odom", "base", -40 * ms));
  EXPECT_FALSE(tree.find("odom", "base", -60 * ms));
}

TEST(TransformTree, LongGapsAreNotInterpolated) {
  TransformTree tree(500 * ms, 50 * ms);
  tree.add(transformAt(0, "odom", "base", 0), false);
  tree.add(transformAt(600 * ms, "odom", "base", 6), false);
  EXPECT_FALSE(tree.find("odom", "base", 300 * ms));
  EXPECT_NEAR(tree.find("odom", "base", 570 * ms)->translation()[0], 6, 1e-12);
}

TEST(TransformTree, BadTransformsAreNotTaken) {
  TransformTree tree(500 * ms, 50 * ms);
  EXPECT_FALSE(tree.add({{0, "a"}, "b", {0, 0, 0, 0, 0, 0, 0}}, false));
  EXPECT_FALSE(tree.add({{0, "a"}, "a", {}}, false));
  EXPECT_FALSE(tree.add({{0, "a"}, "b", {std::numeric_limits<double>::quiet_NaN()}}, false));
  EXPECT_TRUE(tree.empty());
}

TEST(TransformTree, InterpolationTakesTheShorterArc) {
  const Pose quarter{0, 0, 0, 0, 0, std::sqrt(0.5), std::sqrt(0.5)};
  const Pose same{0, 0, 0, 0, 0, -std::sqrt(0.5), -std::sqrt(0.5)};
  EXPECT_NEAR(angleOf(rigidOf(interpolated(quarter, same, 0.5)).inv() * rigidOf(quarter)), 0, 1e-9);
}

}  // namespace
}  // namespace estancia::ros
