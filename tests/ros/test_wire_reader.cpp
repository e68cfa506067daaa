// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/wire_reader.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

#include "estancia/ros/messages.hpp"
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

}  // namespace
}  // namespace estancia::ros
