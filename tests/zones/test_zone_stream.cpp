// Zones that are kept while a robot drives, beside those of the whole run at once.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zone_stream.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/zones/measure.hpp"
#include "recordings.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::driveThrough;
using test::FailsWith;
using test::recordingOf;

ZoneStream streamOf(const DescriptorSequence& recording, const ZoneOptions& options = {},
                    const ZoneStreamOptions& stream = {}) {
  ZoneStream zones(recording.vocabulary, options, stream);
  for (std::size_t i = 0; i < recording.frames.size(); ++i) zones.add(recording.descriptors.row(i));
  zones.update();
  return zones;
}

double agreementWithExact(const DescriptorSequence& recording, const ZoneOptions& options,
                          std::size_t groups) {
  const std::vector<int> exact = findZones(recording, options).zoneOf;
  const ZoneStream stream = streamOf(recording, options, {groups, 20});
  EXPECT_LE(stream.groups(), groups);
  return measureAgreement(exact, stream.zoneOf()).adjustedRandIndex;
}

const DescriptorSequence& drive() {
  static const DescriptorSequence recording = driveThrough({0, 1, 2, 0, 3, 1, 4, 2}, 20);
  return recording;
}

class EveryWay : public testing::TestWithParam<std::pair<const char*, const char*>> {
 protected:
  static ZoneOptions options() {
    ZoneOptions options;
    options.distance = GetParam().first;
    options.linkage = GetParam().second;
    return options;
  }
};

TEST_P(EveryWay, IsExactWhileThereAreGroupsForAllImages) {
  EXPECT_EQ(agreementWithExact(drive(), options(), 160), 1);
}

TEST_P(EveryWay, FindsTheRoomsWithFewGroups) {
  ZoneOptions five = options();
  five.count = 5;
  const ZoneStream stream = streamOf(drive(), five, {40, 20});
  std::vector<int> rooms;
  for (const Frame& frame : drive().frames) rooms.push_back(frame.room.back());
  EXPECT_GT(measureAgreement(rooms, stream.zoneOf()).vMeasure, 0.9);
  EXPECT_EQ(stream.groups(), 40U);
}

INSTANTIATE_TEST_SUITE_P(ZoneStream, EveryWay,
                         testing::Values(std::pair{"standardized-clr", "ward"},
                                         std::pair{"hellinger", "average"}, std::pair{"l2", "complete"}));

TEST(ZoneStream, KeepsTheNumbersOfItsZones) {
  const DescriptorSequence recording = driveThrough({0, 1, 0, 2, 1, 0}, 20);
  ZoneOptions options;
  options.count = 2;
  ZoneStream stream(recording.vocabulary, options, {.groups = 30, .relinkEvery = 5});
  std::vector<int> atTheTime;
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    atTheTime.push_back(stream.add(recording.descriptors.row(i)));
  stream.update();
  const std::vector<int> inTheEnd = stream.zoneOf();
  std::size_t same = 0;
  for (std::size_t i = 40; i < 60; ++i) same += atTheTime[i] == inTheEnd[i] ? 1 : 0;
  EXPECT_GE(same, 18U) << "images of a room seen before go to its zone at once";
}

TEST(ZoneStream, HasItsZonesWithNamesAndMoments) {
  ZoneOptions one;
  one.distance = "l2";
  one.linkage = "average";
  one.count = 1;
  ZoneStream stream = streamOf(recordingOf({{1, 0}, {0, 1}, {0.5F, 0.5F}}), one);
  const std::vector<StreamedZone> zones = stream.zones();
  ASSERT_EQ(zones.size(), 1U);
  EXPECT_EQ(zones[0].images, 3U);
  EXPECT_FLOAT_EQ(zones[0].mean[0], 0.5F);
  EXPECT_NEAR(zones[0].sigma[0], 0.408248, 1e-6);
  EXPECT_EQ(zones[0].name, stream.nameOf(zones[0].id));
  EXPECT_THAT([&] { stream.nameOf(77); }, FailsWith(ErrorCode::unknownName));

  stream = streamOf(drive(), {}, {25, 7});
  const std::vector<int> zoneOf = stream.zoneOf();
  std::size_t images = 0;
  for (const StreamedZone& zone : stream.zones()) {
    images += zone.images;
    EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(zoneOf, zone.id)), zone.images);
  }
  EXPECT_EQ(images, drive().frames.size());
  EXPECT_EQ(streamOf(recordingOf(std::vector<std::vector<float>>(30, {0, 0, 0})), {}, {4, 3}).zones().size(),
            1U);
  ZoneStream empty(Vocabulary({"desk", "cup", "bed"}));
  empty.update();
  EXPECT_TRUE(empty.zones().empty());
}

TEST(ZoneStream, DoesNotDependOnThreads) {
  ZoneOptions one, three;
  one.threads = 1;
  three.threads = 3;
  EXPECT_EQ(streamOf(drive(), one, {50, 20}).zoneOf(), streamOf(drive(), three, {50, 20}).zoneOf());
}

TEST(ZoneStream, SaysHowFarItIsFromTheExactResult) {
  const ZoneStream stream = streamOf(drive(), {}, {40, 20});
  const StreamAgreement all = compareWithExact(drive(), stream.zoneOf(), {});
  EXPECT_EQ(all.images, drive().frames.size());
  const std::vector<int> exact = findZones(drive()).zoneOf;
  EXPECT_EQ(all.zones, std::set<int>(exact.begin(), exact.end()).size());
  EXPECT_EQ(all.agreement.adjustedRandIndex, measureAgreement(exact, stream.zoneOf()).adjustedRandIndex);
  EXPECT_EQ(compareWithExact(drive(), exact, {}).agreement.adjustedRandIndex, 1);
  EXPECT_EQ(compareWithExact(drive(), stream.zoneOf(), {}, 50).images, 50U);
  const std::vector<int> one{1};
  EXPECT_THAT([&] { compareWithExact(drive(), one, {}); }, FailsWith(ErrorCode::mismatch));
}

TEST(ZoneStream, RefusesWhatIsNoProbability) {
  ZoneStream stream(Vocabulary({"desk", "cup"}));
  const std::vector<float> shorter{0.5F}, nan{0.5F, std::numeric_limits<float>::quiet_NaN()};
  EXPECT_THAT([&] { stream.add(shorter); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { stream.add(nan); }, FailsWith(ErrorCode::labelerFailure));
  EXPECT_EQ(stream.images(), 0U) << "nothing of it was kept";
}

TEST(ZoneStream, RefusesOptionsThatDoNotGoTogether) {
  const auto refusal = [](const ZoneOptions& options, const ZoneStreamOptions& stream) {
    return test::caught([&] { ZoneStream(Vocabulary({"desk", "cup"}), options, stream); });
  };
  ZoneOptions both, unknown, tooMany, pooled;
  both.cut = 0.5;
  both.count = 3;
  unknown.distance = "miles";
  pooled.reach = 0.5;
  tooMany.count = 11;
  EXPECT_THAT(refusal(unknown, {}), FailsWith(ErrorCode::unknownName));
  const std::pair<ZoneOptions, ZoneStreamOptions> wrong[] = {
      {both, {}}, {pooled, {}}, {tooMany, {.groups = 10}}, {{}, {.groups = 1}}, {{}, {.relinkEvery = 0}}};
  for (const auto& [zones, stream] : wrong)
    EXPECT_THAT(refusal(zones, stream), FailsWith(ErrorCode::invalidOption));
}

TEST(ZoneStream, EndsInZonesAsOfTheWholeRun) {
  const std::size_t images = drive().frames.size();
  ZoneOptions options;
  options.count = 5;
  ZoneStream stream = streamOf(drive(), options, {.groups = images});
  const Zones streamed = stream.finish(drive()), exact = findZones(drive(), options);
  EXPECT_EQ(streamed.zoneOf, exact.zoneOf) << "numbered by size";
  EXPECT_EQ(streamed.distance, exact.distance);
  EXPECT_EQ(streamed.linkage, exact.linkage);
  EXPECT_NEAR(streamed.cut, exact.cut, 1e-4 * exact.cut);
  EXPECT_EQ(streamed.cutReason, exact.cutReason);
  EXPECT_EQ(streamed.zones[0].name, exact.zones[0].name);

  const DescriptorSequence three = recordingOf({{1, 0}, {0, 1}, {0.5F, 0.5F}});
  ZoneStream tooShort = streamOf(three, options);
  EXPECT_THAT([&] { tooShort.finish(three); }, FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia
