// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/published_messages.hpp"
#include "estancia/ros/wire_reader.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <initializer_list>
#include <limits>

#include "estancia/ros/cdr_writer.hpp"
#include "estancia/ros/messages.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

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

}  // namespace
}  // namespace estancia::ros
