// Zones laid over the places of a map.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/overlay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recordings.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

Zones fourFrames() {  // "0" and "1" in zone 0, "2" and "3" in zones 1 and 2
  return describeZones(test::recordingOf({{1, 0}, {1, 0}, {0, 1}, {0.5F, 0.5F}}),
                       std::vector<int>{0, 0, 1, 2});
}

/// Those frames, in the words of fourFrames().
GroupedRun runOf(std::vector<GroupedFrame> frames) {
  const Zones zones = fourFrames();
  return {std::move(frames), zones.vocabulary, runMean(zones)};
}

TEST(Overlay, TellsTheZoneOfMostFramesAndAllShares) {
  const auto groups = overlayZones(fourFrames(), runOf({{"3", 9}, {"2", 4}, {"1", 9}, {"0", 9}}));
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].group, 4);
  EXPECT_EQ(groups[0].zone(), 1);
  EXPECT_EQ(groups[1].group, 9);
  EXPECT_EQ(groups[1].frames, 3U);
  ASSERT_EQ(groups[1].shares.size(), 2U);
  EXPECT_EQ(groups[1].zone(), 0);
  EXPECT_EQ(groups[1].shares[0].frames, 2U);
  EXPECT_EQ(groups[1].shares[1].zone, 2);
  EXPECT_EQ(findGroup(groups, 9), &groups[1]);
  EXPECT_EQ(findGroup(groups, 5), nullptr);
}

TEST(Overlay, OfEqualSharesTakesTheLargerZone) {
  const auto groups = overlayZones(fourFrames(), runOf({{"3", 1}, {"2", 1}, {"1", 2}, {"0", 2}}));
  EXPECT_EQ(groups[0].zone(), 1) << "zone ids go by size";
}

TEST(Overlay, RefusesARunWhoseFramesAreOnlyNamedAlike) {
  GroupedRun other = runOf({{"0", 1}, {"1", 1}, {"2", 1}, {"3", 1}});
  std::swap(other.mean.front(), other.mean.back());
  EXPECT_THAT([&] { overlayZones(fourFrames(), other); }, FailsWith(ErrorCode::mismatch));
  other.vocabulary = Vocabulary({"of", "another"});
  other.mean = {0.5F, 0.5F};
  EXPECT_EQ(overlayZones(fourFrames(), other).size(), 1U) << "words of another model tell nothing";
}

TEST(Overlay, RefusesAnotherRun) {
  const GroupedRun shorter = runOf({{"0", 1}}), other = runOf({{"0", 1}, {"1", 1}, {"2", 1}, {"other", 1}});
  EXPECT_THAT([&] { overlayZones(fourFrames(), shorter); }, FailsWith(ErrorCode::mismatch, "4 frames", "1"));
  EXPECT_THAT([&] { overlayZones(fourFrames(), other); }, FailsWith(ErrorCode::mismatch, "\"other\""));
}

}  // namespace
}  // namespace estancia
