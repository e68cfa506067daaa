// Zones of runs whose rooms are known, and of runs that are hardly any; their names, quality, and places.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zones.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/zones/measure.hpp"
#include "estancia/zones/naming.hpp"
#include "estancia/zones/overlay.hpp"
#include "recordings.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::driveThrough;
using test::FailsWith;
using test::recordingOf;
using testing::ElementsAre;
using testing::IsEmpty;

/// The frames in another order.
DescriptorSequence shuffled(const DescriptorSequence& recording, const std::vector<std::size_t>& order) {
  DescriptorSequence result{
      recording.vocabulary, recording.model, {}, DescriptorMatrix(recording.vocabulary.size())};
  for (const std::size_t i : order) {
    result.frames.push_back(recording.frames[i]);
    result.descriptors.append(recording.descriptors.row(i));
  }
  return result;
}

TEST(Zones, AreTheRoomsOfADrive) {
  const DescriptorSequence recording = driveThrough({0, 1, 2, 0, 3, 1}, 15);
  const Zones zones = findZones(recording);
  ASSERT_EQ(zones.zones.size(), 4U);
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    EXPECT_EQ(zones.zones[static_cast<std::size_t>(zones.zoneOf[i])].room, recording.frames[i].room);
  EXPECT_EQ(zones.zones[0].images.size(), 30U) << "the largest is zone 0";
  EXPECT_EQ(zones.zones[0].room, "room 0") << "of equal ones the one seen first";
  EXPECT_EQ(zones.zones[1].room, "room 1");
  EXPECT_EQ(zones.zones[0].roomShare, 1);
  EXPECT_EQ(zones.model, "test");
  EXPECT_FALSE(zones.cutReason.empty());
  EXPECT_EQ(zones.dendrogram.value().cutAt(zones.cut), zones.dendrogram->cutInto(4));
}

TEST(Zones, TellMeanSpreadAndMembers) {
  const DescriptorSequence recording = recordingOf({{1, 0}, {0, 1}, {0.5F, 0.5F}});
  const Zones zones = describeZones(recording, std::vector<int>{7, -2, 7});
  ASSERT_EQ(zones.zones.size(), 2U);
  EXPECT_THAT(zones.zoneOf, ElementsAre(0, 1, 0));
  EXPECT_THAT(zones.zones[0].images, ElementsAre(0, 2));
  EXPECT_THAT(zones.zones[0].mean, ElementsAre(0.75F, 0.25F));
  EXPECT_THAT(zones.zones[0].sigma, ElementsAre(0.25F, 0.25F));
  EXPECT_THAT(zones.zones[1].sigma, ElementsAre(0, 0));
  EXPECT_THAT(runMean(zones), ElementsAre(0.5F, 0.5F));
  EXPECT_EQ(zones.zones[0].name, "word 0, word 1");
  EXPECT_EQ(zones.zones[1].name, "word 1");
}

TEST(Zones, KnowTheRoomsTheyAreIn) {
  DescriptorSequence recording = recordingOf({{1, 0}, {1, 0}, {1, 0}, {0, 1}, {1, 0}});
  recording.frames[0].room = "kitchen";
  recording.frames[1].room = "hall";
  recording.frames[2].room = "hall";
  const Zones zones = describeZones(recording, std::vector<int>{0, 0, 0, 1, 0});
  EXPECT_EQ(zones.zones[0].room, "hall");
  EXPECT_NEAR(zones.zones[0].roomShare, 2.0 / 3, 1e-12) << "of those whose room is known";
  EXPECT_EQ(zones.zones[1].room, "");
  ASSERT_EQ(zones.rooms.size(), 2U);
  EXPECT_EQ(zones.rooms[0].name, "hall");
  EXPECT_EQ(zones.rooms[0].images, 2U);
  EXPECT_THAT(zones.rooms[0].mean, ElementsAre(1, 0));
}

TEST(Zones, LieWhereTheirPosedImagesWereTaken) {
  DescriptorSequence recording = recordingOf({{1, 0}, {1, 0}, {1, 0}, {0, 1}});
  recording.frames[0].pose = Pose::planar(1, 2, 0);  // the trajectory ends after two images
  recording.frames[1].pose = Pose::planar(3, 2, 0);
  const Zones zones = describeZones(recording, std::vector<int>{0, 0, 0, 1});
  ASSERT_TRUE(zones.zones[0].extent);
  EXPECT_THAT(zones.zones[0].extent->center, ElementsAre(2, 2, 0));
  EXPECT_EQ(zones.zones[0].extent->spread, 1);
  EXPECT_EQ(zones.zones[0].extent->images, 2U);
  EXPECT_FALSE(zones.zones[1].extent);
  const auto json = toJson(zones, 1)["zones"][0];
  EXPECT_EQ(json["position"], (nlohmann::ordered_json{2, 2, 0}));
  EXPECT_EQ(json["spread"], 1);
}

TEST(Zones, AreCutWhereTheyAreTold) {
  const DescriptorSequence recording = driveThrough({0, 1, 2, 3}, 10);
  ZoneOptions options;
  options.count = 7;
  const Zones seven = findZones(recording, options);
  EXPECT_EQ(seven.zones.size(), 7U);
  EXPECT_EQ(seven.cutReason, "7 zones were asked for");
  options.count.reset();
  options.cut = seven.cut;
  EXPECT_EQ(findZones(recording, options).zoneOf, seven.zoneOf) << "the cut that comes with the count";
  options.cut = 0;
  EXPECT_EQ(findZones(recording, options).zones.size(), recording.frames.size());
  options.cut = 1e9;
  EXPECT_EQ(findZones(recording, options).zones.size(), 1U);
}

TEST(Zones, ByTheThesisMergeUpToTheirThreshold) {
  // Eq. 5.1: the first two are .3 apart, the third is .7 and 1 from them: .85 from their cluster.
  const DescriptorSequence recording = recordingOf({{1, 0}, {0.7F, 0.3F}, {0, 1}});
  const ZoneOptions thesis = ZoneOptions::thesis();
  EXPECT_EQ(thesis.distance, "ks");
  EXPECT_EQ(thesis.linkage, "average");
  EXPECT_EQ(thesis.cut, 0.5);
  const Zones zones = findZones(recording, thesis);
  EXPECT_THAT(zones.zoneOf, ElementsAre(0, 0, 1));
  EXPECT_NEAR(zones.dendrogram.value().merges()[0].height, 0.3, 1e-6);
  EXPECT_NEAR(zones.dendrogram->merges()[1].height, 0.85, 1e-6);
  EXPECT_EQ(zones.cut, 0.5);
}

/// Algorithm 5.1 step by step, the stop test the right way round.
std::vector<int> slowAlgorithm51(const DescriptorMatrix& images, double threshold) {
  std::vector<std::vector<std::size_t>> clusters;
  for (std::size_t i = 0; i < images.size(); ++i) clusters.push_back({i});
  const auto ks = [&](std::size_t a, std::size_t b) {
    double most = 0;
    for (std::size_t l = 0; l < images.labels(); ++l)
      most = std::max(
          most, std::abs(static_cast<double>(images.row(a)[l]) - static_cast<double>(images.row(b)[l])));
    return most;
  };
  const auto average = [&](const auto& a, const auto& b) {
    double sum = 0;
    for (const std::size_t i : a)
      for (const std::size_t j : b) sum += ks(i, j);
    return sum / static_cast<double>(a.size() * b.size());
  };
  while (clusters.size() > 1) {
    std::size_t first = 0, second = 1;
    for (std::size_t i = 0; i < clusters.size(); ++i)
      for (std::size_t j = i + 1; j < clusters.size(); ++j)
        if (average(clusters[i], clusters[j]) < average(clusters[first], clusters[second]))
          first = i, second = j;
    if (average(clusters[first], clusters[second]) > threshold) break;
    clusters[first].insert(clusters[first].end(), clusters[second].begin(), clusters[second].end());
    clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(second));
  }
  std::vector<int> groups(images.size());
  for (std::size_t c = 0; c < clusters.size(); ++c)
    for (const std::size_t i : clusters[c]) groups[i] = static_cast<int>(c);
  return groups;
}

TEST(Zones, AreThoseOfAlgorithm51) {
  const DescriptorSequence recording = driveThrough({0, 1, 2, 3, 4}, 6, 11);
  for (const double cut : {0.05, 0.2, 0.5}) {
    ZoneOptions options = ZoneOptions::thesis();
    options.cut = cut;
    const std::vector<int> slow = slowAlgorithm51(recording.descriptors, cut);
    EXPECT_EQ(measureAgreement(slow, findZones(recording, options).zoneOf).adjustedRandIndex, 1)
        << "τ_d " << cut;
  }
}

/// A robot that looks around in rooms 0, 1, 2: in each it sees four things, two of them in every room.
DescriptorSequence lookedAround() {
  test::SyntheticPlaces things(8, 20, 0.3);
  std::vector<std::vector<float>> rows;
  DescriptorSequence recording = recordingOf({things.image(0)});
  recording.frames.clear();
  recording.descriptors = DescriptorMatrix(20);
  for (std::size_t room = 0; room < 3; ++room)
    for (std::size_t i = 0; i < 40; ++i) {
      const std::size_t side = i / 10;
      Frame frame;
      frame.name = std::to_string(recording.frames.size());
      frame.room = "room " + std::to_string(room);
      frame.pose = Pose::planar(4.0 * static_cast<double>(room), 0.01 * static_cast<double>(i), 0);
      recording.frames.push_back(frame);
      recording.descriptors.append(things.image(side < 2 ? side : 2 * room + side));
    }
  return recording;
}

double agreementWithRooms(const Zones& zones) {
  std::vector<int> rooms;
  for (const Frame& frame : zones.frames) rooms.push_back(frame.room.back());
  return measureAgreement(rooms, zones.zoneOf).vMeasure;
}

TEST(ZonesOfARun, AreWhatIsSeenAroundAPlace) {
  const DescriptorSequence recording = lookedAround();
  ZoneOptions options;
  EXPECT_LT(agreementWithRooms(findZones(recording)), 0.8);
  options.reach = 0.5;
  options.threads = 1;
  const Zones zones = findZones(recording, options);
  EXPECT_EQ(agreementWithRooms(zones), 1);
  options.threads = 3;
  EXPECT_EQ(findZones(recording, options).zoneOf, zones.zoneOf);
  const DescriptorView first = recording.descriptors.row(zones.zones[0].images[0]);
  EXPECT_NE(zones.zones[0].mean, std::vector<float>(first.begin(), first.end()));
  std::vector<std::size_t> order(recording.frames.size());
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  EXPECT_EQ(agreementWithRooms(findZones(shuffled(recording, order), options)), 1) << "poses need no order";
}

TEST(ZonesOfARun, NeedNoPoses) {
  DescriptorSequence recording = driveThrough({0, 1, 2, 0, 3}, 12);
  ZoneOptions options;
  options.reach = 0.5;
  EXPECT_GT(agreementWithRooms(findZones(recording, options)), 0.8);
  for (Frame& frame : recording.frames) frame.pose = Pose{};
  EXPECT_GT(agreementWithRooms(findZones(recording, options)), 0.8) << "poses that never move say nothing";
  recording = lookedAround();
  for (std::size_t i = 0; i < recording.frames.size(); i += 3) recording.frames[i].pose.reset();
  EXPECT_GT(agreementWithRooms(findZones(recording, options)), 0.6) << "where some are missing";
}

TEST(Zones, TakeOneImageEqualImagesAndThoseThatSayNothing) {
  ZoneOptions around;
  around.reach = 0.5;
  const std::vector<std::vector<float>> same(20, {0.2F, 0.7F, 0.1F});
  for (const ZoneOptions& options : {ZoneOptions{}, ZoneOptions::thesis(), around}) {
    EXPECT_EQ(findZones(recordingOf({{0.5F, 0.5F}}), options).zones.size(), 1U);
    EXPECT_EQ(findZones(recordingOf(same), options).zones.size(), 1U);
  }
  EXPECT_EQ(findZones(recordingOf({{0.1F}, {0.9F}, {0.5F}}), ZoneOptions::thesis()).zones.size(), 2U)
      << "of one label";
  std::vector<std::vector<float>> rows(12, {0, 0, 0});
  EXPECT_EQ(findZones(recordingOf(rows)).zones.size(), 1U);
  EXPECT_EQ(findZones(recordingOf(rows)).zones[0].name, "no words");
  for (int i = 0; i < 12; ++i) rows.push_back({0.9F, 0.1F, 0});
  for (const Choice& linkage : linkages())
    for (const char* distance : {"standardized-clr", "cosine"}) {
      ZoneOptions options;
      options.distance = distance;
      options.linkage = linkage.name;
      EXPECT_EQ(findZones(recordingOf(rows), options).zones.size(), 2U) << distance << ' ' << linkage.name;
    }
}

TEST(Zones, RefuseWhatCannotBe) {
  const DescriptorSequence recording = recordingOf({{1, 0}, {0, 1}});
  const auto refusal = [&](void (*change)(ZoneOptions&)) {
    ZoneOptions options;
    change(options);
    return test::caught([&] { findZones(recording, options); });
  };
  EXPECT_THAT(refusal([](ZoneOptions& o) { o.distance = "bogus"; }),
              FailsWith(ErrorCode::unknownName, "bogus", "standardized-clr"));
  EXPECT_THAT(refusal([](ZoneOptions& o) { o.linkage = "bogus"; }), FailsWith(ErrorCode::unknownName));
  void (*const changes[])(ZoneOptions&) = {
      [](ZoneOptions& o) { o.cut = std::nan(""); }, [](ZoneOptions& o) { o.cut = -1; },
      [](ZoneOptions& o) { o.reach = -1; },         [](ZoneOptions& o) { o.count = 3; },
      [](ZoneOptions& o) { o.count = 0; },          [](ZoneOptions& o) { o.count = 1, o.cut = 1; }};
  for (std::size_t i = 0; i < std::size(changes); ++i)
    EXPECT_THAT(refusal(changes[i]), FailsWith(ErrorCode::invalidOption)) << i;
  const DescriptorSequence empty{Vocabulary({"a"}), "test", {}, DescriptorMatrix(1)};
  EXPECT_THAT([&] { findZones(empty); }, FailsWith(ErrorCode::insufficientData));
  const std::vector<int> one{1};
  EXPECT_THAT([&] { describeZones(recording, one); }, FailsWith(ErrorCode::mismatch));
}

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

Zones fourFrames() {  // "0" and "1" in zone 0, "2" and "3" in zones 1 and 2
  return describeZones(test::recordingOf({{1, 0}, {1, 0}, {0, 1}, {0.5F, 0.5F}}),
                       std::vector<int>{0, 0, 1, 2});
}

/// A run of these frames, in the words of fourFrames().
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

TEST(Overlay, RefusesAnotherRunAlsoWhoseFramesAreNamedAlike) {
  const GroupedRun shorter = runOf({{"0", 1}}),
                   stranger = runOf({{"0", 1}, {"1", 1}, {"2", 1}, {"other", 1}});
  EXPECT_THAT([&] { overlayZones(fourFrames(), shorter); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { overlayZones(fourFrames(), stranger); }, FailsWith(ErrorCode::mismatch));
  GroupedRun other = runOf({{"0", 1}, {"1", 1}, {"2", 1}, {"3", 1}});
  std::swap(other.mean.front(), other.mean.back());
  EXPECT_THAT([&] { overlayZones(fourFrames(), other); }, FailsWith(ErrorCode::mismatch));
  other.vocabulary = Vocabulary({"of", "another"});
  other.mean = {0.5F, 0.5F};
  EXPECT_EQ(overlayZones(fourFrames(), other).size(), 1U) << "words of another model tell nothing";
}

const Vocabulary words({"room", "n03761084 microwave, microwave oven", "stove", "tub", "crane", "crane"});

TEST(TellingLabels, AreLikelyHereAndUnlikelyElsewhere) {
  const std::vector<float> run{0.6F, 0.1F, 0.1F, 0.1F, 0.05F, 0.05F};
  const std::vector<float> kitchen{0.6F, 0.25F, 0.15F, 0, 0, 0};
  EXPECT_THAT(distinctiveLabels(kitchen, run, 2), ElementsAre(1, 2)) << "every place is a room";
  EXPECT_THAT(distinctiveLabels(kitchen, run, 9), ElementsAre(1, 2, 0))
      << "then what is likely; never what is not";
  EXPECT_THAT(distinctiveLabels(run, run, 2), ElementsAre(0, 1)) << "the run itself: its likeliest words";
  EXPECT_THAT(distinctiveLabels(std::vector<float>(6, 0), run, 2), IsEmpty());
}

TEST(ZoneNames, AreTheMostTellingWords) {
  const std::vector<float> run{0.6F, 0.1F, 0.1F, 0.1F, 0.05F, 0.05F};
  const auto names = nameZones(words, {{0.5F, 0.3F, 0.2F, 0, 0, 0}, {0.5F, 0, 0, 0.4F, 0.05F, 0.05F}}, run);
  EXPECT_THAT(names, ElementsAre("microwave, stove, room", "tub, room, crane"));
}

TEST(ZoneNames, GrowUntilTheyDiffer) {
  const std::vector<float> run{0.2F, 0.2F, 0.2F, 0.1F, 0.1F, 0.1F};
  const std::vector<std::vector<float>> zones{{0.5F, 0.4F, 0.3F, 0, 0, 0},
                                              {0.4F, 0.5F, 0.3F, 0.05F, 0, 0},
                                              {0.5F, 0.4F, 0.3F, 0, 0, 0},
                                              {0, 0, 0, 0, 0, 0}};
  EXPECT_THAT(nameZones(words, zones, run),
              ElementsAre("room, microwave, stove", "microwave, room, stove, tub", "room, microwave, stove",
                          "no words"))
      << "the third has no more to say than the first";
}

TEST(ZoneNames, MayBeConceptsOfTheirLabels) {
  const LabelConcepts concepts{{"lift", 0.6, {4, 5}, {0, 4, 5}}};
  const std::vector<float> run{0.2F, 0.2F, 0.2F, 0.2F, 0.1F, 0.1F};
  EXPECT_THAT(nameZones(words, {{0.1F, 0, 0.05F, 0.01F, 0.4F, 0.4F}}, run, concepts),
              ElementsAre("lift, stove, tub"))
      << "neither a crane beside it nor the room, which it covers";
}

TEST(ZoneOptions, SayWhichWordsNameZones) {
  ZoneOptions options;
  OptionGroup group = declare(options);
  EXPECT_EQ(group.find("naming.words")->text(), "wordnet");
  group.set("naming.words", "raw");
  EXPECT_EQ(options.naming.words, NamingOptions::Words::raw);
  const Vocabulary dogs({"Labrador retriever", "golden retriever", "beagle", "stove"});
  DescriptorSequence sequence{dogs, "", {}, DescriptorMatrix(4)};
  for (int i = 0; i < 4; ++i) {
    sequence.frames.emplace_back().name = std::to_string(i);
    sequence.descriptors.append(i < 2 ? std::vector<float>{0.35F, 0.34F, 0.31F, 0}
                                      : std::vector<float>{0, 0, 0, 1});
  }
  const std::vector<int> groups{0, 0, 1, 1};
  EXPECT_EQ(describeZones(sequence, groups, options.naming).zones.front().name,
            "Labrador retriever, golden retriever, beagle");
  EXPECT_EQ(describeZones(sequence, groups).zones.front().name, "dog");
}

}  // namespace
}  // namespace estancia
