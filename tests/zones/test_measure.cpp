// Zone quality by hand.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/measure.hpp"

#include <gtest/gtest.h>

#include "recordings.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::recordingOf;

constexpr double tight = 1e-12;

TEST(ZoneQuality, ComparesWithRoomsWhereTheyAreKnown) {
  DescriptorSequence recording = recordingOf({{1, 0}, {1, 0}, {0, 1}, {0, 1}, {0, 1}});
  const std::vector<int> groups{0, 0, 1, 1, 1};
  const ZoneQuality unknown = evaluate(describeZones(recording, groups));
  EXPECT_FALSE(unknown.rooms);
  EXPECT_FALSE(unknown.spatialSpread);
  EXPECT_EQ(unknown.zones, 2U);
  EXPECT_EQ(unknown.frames, 5U);

  for (const std::size_t i : {0U, 1U}) recording.frames[i].room = "kitchen";
  for (const std::size_t i : {2U, 3U}) recording.frames[i].room = "bath";
  for (const std::size_t i : {0U, 1U})
    recording.frames[i].pose = Pose::planar(static_cast<double>(i) * 2, 0, 0);
  const ZoneQuality known = evaluate(describeZones(recording, groups));
  EXPECT_EQ(known.framesWithRoom, 4U);
  EXPECT_NEAR(known.rooms.value().vMeasure, 1, tight);
  EXPECT_NEAR(known.spatialSpread.value(), 1, tight);
}

TEST(ZoneQuality, ComparesWithTheRoomsThatAreSeen) {
  const DescriptorSequence recording = recordingOf({{1, 0}, {1, 0}, {0, 1}, {0, 1}, {0, 1}});
  const Zones zones = describeZones(recording, std::vector{0, 0, 1, 1, 1});
  EXPECT_FALSE(evaluate(zones).roomsSeen);
  const ZoneQuality quality =
      evaluate(zones, std::vector<std::string>{"kitchen", "", "bath", "bath", "kitchen"});
  EXPECT_EQ(quality.framesWithRoomSeen, 4U);
  EXPECT_DOUBLE_EQ(quality.roomsSeen.value().purity, 0.75);
  EXPECT_FALSE(quality.rooms);
  EXPECT_THAT([&] { evaluate(zones, std::vector<std::string>{"kitchen"}); },
              test::FailsWith(ErrorCode::mismatch));
}

}  // namespace
}  // namespace estancia
