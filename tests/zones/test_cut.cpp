// Zones of a stream of images, and where their tree is cut.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/image_tree.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/zones/measure.hpp"
#include "estancia/zones/zone_stream.hpp"
#include "recordings.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::driveThrough;
using test::FailsWith;
using test::recordingOf;
using testing::ElementsAre;

CondensedDistances distancesOf(const std::vector<double>& points) {
  CondensedDistances distances(points.size());
  std::size_t at = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j)
      distances.values()[at++] = std::abs(points[i] - points[j]);
  return distances;
}

SuggestedCut suggestionFor(const std::vector<double>& points, std::size_t neighbors = 5) {
  return suggestCut(link(distancesOf(points), Linkage::average),
                    findNeighbors(distancesOf(points), neighbors));
}

TEST(NearestItems, AreTheNearestOfEqualOnesTheFirst) {
  const NearestItems two = findNeighbors(distancesOf({0, 1, 2, 10, 3}), 2);
  EXPECT_EQ(two.each, 2U);
  EXPECT_THAT(two.nearest, ElementsAre(1, 2,    // 0
                                       0, 2,    // 1: both at 1
                                       1, 4,    // 2
                                       4, 2,    // 10
                                       2, 1));  // 3
}

TEST(NearestItems, AreWantedByTheRootOfTheNumberOfItems) {
  EXPECT_EQ(neighborsForCut(1), 3U);
  EXPECT_EQ(neighborsForCut(216), 5U);
  EXPECT_EQ(neighborsForCut(1173), 11U);
}

/// Newman's definition, term by term: Q = 1/W Σ_ij (A_ij − k_i k_j / W) [i and j in one part].
double slowModularity(const NearestItems& neighbors, const std::vector<int>& parts) {
  const std::size_t n = parts.size();
  std::vector<std::vector<double>> weights(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < neighbors.each; ++k) {
      const std::size_t link = i * neighbors.each + k, j = neighbors.nearest[link];
      const double weight = neighbors.weights.empty() ? 1 : neighbors.weights[link];
      weights[i][j] += weight / 2;
      weights[j][i] += weight / 2;
    }
  for (std::size_t i = 0; i < neighbors.within.size(); ++i) weights[i][i] += neighbors.within[i];
  std::vector<double> degrees(n);
  double total = 0, q = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      degrees[i] += weights[i][j];
      total += weights[i][j];
    }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      if (parts[i] == parts[j]) q += (weights[i][j] - degrees[i] * degrees[j] / total) / total;
  return q;
}

TEST(SuggestedCut, HasTheLargestModularityOfAllCuts) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 4; ++trial) {
    std::vector<double> points;
    std::vector<std::size_t> sizes;
    for (int i = 0; i < 60; ++i) {
      points.push_back(normal(random) + 4.0 * static_cast<double>(random() % 5));
      sizes.push_back(1 + random() % 4);
    }
    for (const Linkage linkage : {Linkage::average, Linkage::single, Linkage::ward}) {
      const Dendrogram tree = link(distancesOf(points), linkage);
      NearestItems neighbors = findNeighbors(distancesOf(points), 5);
      if (trial % 2 == 1) weighBySize(neighbors, sizes);
      double best = 0;
      for (std::size_t count = 1; count <= points.size(); ++count)
        best = std::max(best, slowModularity(neighbors, tree.cutInto(count)));
      const SuggestedCut cut = suggestCut(tree, neighbors);
      EXPECT_NEAR(cut.modularity, best, 1e-9);
      EXPECT_NEAR(slowModularity(neighbors, tree.cutAt(cut.distance)), best, 1e-9) << "the cut that is said";
    }
  }
}

TEST(NearestItems, OfGroupsWeighAsTheirImages) {
  NearestItems neighbors = findNeighbors(distancesOf({0, 1, 3, 7}), 3);
  weighBySize(neighbors, std::vector<std::size_t>{2, 1, 5, 1});
  EXPECT_THAT(neighbors.nearest, ElementsAre(1, 2, 3, 0, 2, 3, 1, 0, 3, 2, 1, 0));
  EXPECT_THAT(neighbors.within, ElementsAre(2, 0, 15, 0));
  EXPECT_THAT(neighbors.weights, ElementsAre(2, 2, 0, 2, 1, 0, 0, 0, 0, 3, 0, 0));
  const std::vector<std::size_t> two{1, 2};
  EXPECT_THAT([&] { weighBySize(neighbors, two); }, FailsWith(ErrorCode::mismatch));
  const Dendrogram ofThree = link(distancesOf({1, 2, 3}), Linkage::average);
  EXPECT_THAT([&] { suggestCut(ofThree, neighbors); }, FailsWith(ErrorCode::mismatch));
}

TEST(SuggestedCut, LeavesTogetherWhatIsAlikeOrTooFew) {
  for (const std::vector<double>& points :
       {std::vector<double>(20, 1.0), std::vector<double>{1}, std::vector<double>{1, 2, 3, 50}}) {
    const SuggestedCut cut = suggestionFor(points);
    const std::vector<int> groups = link(distancesOf(points), Linkage::average).cutAt(cut.distance);
    EXPECT_EQ(std::set<int>(groups.begin(), groups.end()).size(), 1U);
    EXPECT_EQ(cut.modularity, 0);
  }
}

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
