// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/published_messages.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "estancia/ros/cdr_writer.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::ros {
namespace {

using test::FailsWith;

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
