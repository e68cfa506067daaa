// Labels and rooms: their names, and what is known of rooms.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/label_words.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/similar_names.hpp"
#include "estancia/core/temporal_segments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/log_opinion_pool.hpp"
#include "estancia/core/vocabulary.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(Vocabulary, ReadsOneLabelALineAndRefusesAnEmptyOne) {
  const test::ScratchFolder folder;
  const auto labelsOf = [&](const std::string& text) {
    test::writeFile(folder / "labels.txt", text);
    return readVocabulary(folder / "labels.txt").labels();
  };
  EXPECT_THAT(labelsOf("tench, Tinca tinca\r\ngoldfish  \r\n\r\n"),
              ElementsAre("tench, Tinca tinca", "goldfish"));
  EXPECT_THAT(labelsOf("\xEF\xBB\xBF"
                       "crane\nheron\ncrane\n"),
              ElementsAre("crane", "heron", "crane"));
  EXPECT_THAT(labelsOf("n01440764\ttench\nred\x1B[2J\ncaf\xE9\n"),
              ElementsAre("n01440764 tench", "red\\x1B[2J", "caf\\xE9"))
      << "no control characters";
  for (const char* text : {"cup\n\nmug\n", "\r\n"})
    EXPECT_THAT([&] { labelsOf(text); }, FailsWith(ErrorCode::malformedFile)) << text;
  EXPECT_THAT([&] { readVocabulary(folder / "none.txt"); }, FailsWith(ErrorCode::fileUnreadable));
}

TEST(Vocabulary, RefusesAnother) {
  const Vocabulary mug({"cup", "mug"}), jug({"cup", "jug"});
  EXPECT_THAT([&] { requireSameVocabulary(mug, jug, "map.estancia"); }, FailsWith(ErrorCode::mismatch));
}

TEST(Vocabulary, OfSeveralModelsHasParts) {
  const std::vector<std::string> labels{"cup", "cat", "kitchen"};
  const Vocabulary whole(labels), parted(labels, {{2, 1}, {1, 0.5F}});
  EXPECT_EQ(whole.layout().parts.size(), 1U);
  EXPECT_EQ(parted.layout().labels(), 3U);
  EXPECT_FALSE(whole == parted) << "the same words, compared otherwise";
  EXPECT_FALSE(parted == Vocabulary(labels, {{2, 1}, {1, 1}}));
  EXPECT_TRUE(whole == Vocabulary(labels, {{3, 1}}));
  EXPECT_THAT([&] { Vocabulary(labels, {{2, 1}}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { Vocabulary({}); }, FailsWith(ErrorCode::invalidInput));
  for (std::size_t count = 1; count <= 9; ++count)
    for (std::size_t bad = 0; bad < count; ++bad)
      for (const LabelPart& wrong : {LabelPart{0, 1}, {2, 1}, {1, 0}, {1, -1}, {1, INFINITY}}) {
        std::vector<LabelPart> parts(count, {1, 0.5F});
        parts[bad] = wrong;
        const std::vector<std::string> all(count - 1 + wrong.size + (wrong.size == 2 ? 1 : 0), "cup");
        EXPECT_THAT([&] { Vocabulary(all, parts); }, FailsWith(ErrorCode::invalidInput)) << bad;
      }
}

const Vocabulary& vocabulary() {
  static const Vocabulary words({"tench, Tinca tinca", "cup, mug", "coffee mug", "dining table, board",
                                 "desk", "umbrella", "n04070727 refrigerator, icebox", "battery",
                                 "bookshelf, shelf", "glove", "bus", "T-shirt", "dining_room", "Café"});
  return words;
}

std::vector<std::string> found(const std::string& words) {
  std::vector<std::string> labels;
  for (const std::size_t i : findLabels(vocabulary(), words)) labels.push_back(vocabulary()[i]);
  return labels;
}

TEST(FindLabels, KnowsSynonymsPluralsAndOtherSpellings) {
  for (const auto& [words, label] : {std::pair{"MUG", "cup, mug"},
                                     {" tinca  Tinca ", "tench, Tinca tinca"},
                                     {"coffee mug", "coffee mug"},
                                     {"Icebox", "n04070727 refrigerator, icebox"},
                                     {"CAFÉ", "Café"},
                                     {"t shirt", "T-shirt"},
                                     {"dining-room", "dining_room"},
                                     {"umbrellas", "umbrella"},
                                     {"batteries", "battery"},
                                     {"shelves", "bookshelf, shelf"},
                                     {"gloves", "glove"},
                                     {"buses", "bus"}})
    EXPECT_THAT(found(words), ElementsAre(label)) << words;
}

TEST(LabelsNamed, AreThoseOfExactlyThatName) {
  const auto named = [](const char* words) {
    std::vector<std::string> labels;
    for (const std::size_t i : labelsNamed(vocabulary(), words)) labels.push_back(vocabulary()[i]);
    return labels;
  };
  EXPECT_THAT(named("Mugs"), ElementsAre("cup, mug"));
  EXPECT_THAT(named("dining room"), ElementsAre("dining_room"));
  EXPECT_THAT(named("table"), IsEmpty()) << "a part of a name";
  EXPECT_THAT(named("red umbrella"), IsEmpty()) << "more than a name";
  EXPECT_THAT(named(""), IsEmpty());
  const Vocabulary glasses({"glass", "glasses"});
  EXPECT_THAT(labelsNamed(glasses, "glasses"), ElementsAre(1U)) << "the name itself before a plural";
}

TEST(FindLabels, FallsBackToWholeWordsInsideThenToTheLongestSynonym) {
  EXPECT_THAT(found("table"), ElementsAre("dining table, board"));
  EXPECT_THAT(found("dining"), ElementsAre("dining table, board", "dining_room"));
  EXPECT_THAT(found("tab"), IsEmpty()) << "half a word is none";
  EXPECT_THAT(found("table dining"), IsEmpty());
  EXPECT_THAT(found("red umbrella"), ElementsAre("umbrella"));
  EXPECT_THAT(found("my coffee mug"), ElementsAre("coffee mug"));
  for (const char* nothing : {"", " ,;- ", "zebra"}) EXPECT_THAT(found(nothing), IsEmpty());
}

TEST(NearSpellings, AreNearestFirst) {
  EXPECT_THAT(findNearSpellings(vocabulary(), "umbrela"), ElementsAre("umbrella"));
  EXPECT_THAT(findNearSpellings(vocabulary(), "refridgerator"), ElementsAre("refrigerator"));
  EXPECT_THAT(findNearSpellings(vocabulary(), "tabel"), ElementsAre("table"));
  EXPECT_THAT(findNearSpellings(vocabulary(), "cofee mug"), ElementsAre("coffee mug"));
  EXPECT_THAT(findNearSpellings(vocabulary(), "xylophone"), IsEmpty());
  EXPECT_THAT(findNearSpellings(vocabulary(), std::string(100000, 'x')), IsEmpty());
}

TEST(EditDistance, CountsASwapOnce) {
  EXPECT_EQ(editDistance("", "abc"), 3U);
  EXPECT_EQ(editDistance("abc", "abc"), 0U);
  EXPECT_EQ(editDistance("abc", "acb"), 1U);
  EXPECT_EQ(editDistance("kitten", "sitting"), 3U);
  EXPECT_EQ(editDistance("ca", "abc"), 3U) << "restricted: no part is edited twice";
}

TEST(ShortLabel, IsTheFirstSynonym) {
  EXPECT_EQ(shortLabel("n04070727 refrigerator, icebox"), "refrigerator");
  EXPECT_EQ(shortLabel("desk"), "desk");
  EXPECT_EQ(shortLabel("n0 desk"), "n0 desk");
}

TEST(BestLabels, AreTheMostProbableFirstAndOfEqualOnesTheEarlier) {
  const std::vector<float> probabilities{0.1F, 0.4F, 0.1F, 0.3F};
  EXPECT_THAT(bestLabels(probabilities, 3), ElementsAre(1U, 3U, 0U));
  EXPECT_EQ(bestLabels(probabilities, 9).size(), 4U);
}

TEST(SimilarNames, DifferInCaseOrBlanksAtTheEndsAndAreToldTogether) {
  EXPECT_TRUE(isSimilar("Kitchen", "kitchen"));
  EXPECT_TRUE(isSimilar(" kitchen\t", "kitchen"));
  EXPECT_FALSE(isSimilar("kitchen", "kitchen")) << "they are the same";
  EXPECT_FALSE(isSimilar("living room", "livingroom"));
  EXPECT_FALSE(isSimilar("", "kitchen"));
  EXPECT_EQ(warningsOfSimilarRooms({"Kitchen", "bath", "kitchen", "kitchen "}).size(), 1U);
  EXPECT_TRUE(warningsOfSimilarRooms({"bath", "kitchen"}).empty());
}

RoomPredictions predictions(const std::vector<std::vector<float>>& rows) {
  RoomPredictions made{"test", {"kitchen", "office"}, DescriptorMatrix(2)};
  for (const auto& row : rows) made.probabilities.append(row);
  return made;
}

TEST(RoomPredictions, ArePooledByTheMeanOfTheirLogarithmsWithoutImagesOfWhichNothingWasSaid) {
  const auto pooled =
      poolRooms(predictions({{0.9F, 0.1F}, {0.6F, 0.4F}, {0, 1}}), std::vector<std::size_t>{0, 0, 1}, 2);
  ASSERT_EQ(pooled.size(), 2U);
  EXPECT_EQ(pooled[0][0].room, "kitchen");
  // √(0.9 · 0.6) / (√(0.9 · 0.6) + √(0.1 · 0.4))
  EXPECT_NEAR(pooled[0][0].probability, 0.7860612, 1e-6);
  EXPECT_NEAR(pooled[0][0].probability + pooled[0][1].probability, 1, 1e-12);
  EXPECT_EQ(pooled[1][0].room, "office");
  EXPECT_NEAR(pooled[1][0].probability, 1 / 1.001, 1e-9) << "a 0 is no proof";
  const auto some = poolRooms(predictions({{0.9F, 0.1F}, {0, 0}, {0, 0}, {0.5F, 0.5F}}),
                              std::vector<std::size_t>{0, 0, 1, 7, 0}, 2);
  EXPECT_NEAR(some[0][0].probability, 0.9, 1e-6);
  EXPECT_THAT(some[1], IsEmpty());
  EXPECT_THAT(rankedRooms(predictions({{0, 0}}), 0), IsEmpty());
  EXPECT_THAT(rankedRooms(predictions({{0.2F, 0.8F}}), 1), IsEmpty());
  EXPECT_EQ(rankedRooms(predictions({{0.2F, 0.8F}}), 0).front().room, "office");
}

TEST(RoomPredictions, ArePooledWithoutHowOftenRoomsOccur) {
  RoomPredictions made = predictions({{0.9F, 0.1F}, {0, 0}});
  made.prior = {0.9, 0.1};
  const auto pooled = poolRooms(made, std::vector<std::size_t>{0, 1}, 2);
  EXPECT_NEAR(pooled[0][0].probability, 0.5, 1e-6) << "all that was said is that most images are of kitchens";
  EXPECT_THAT(pooled[1], IsEmpty());
}

TEST(RoomPredictions, AreNotSureByOneLabel) {
  RoomPredictions made{"test", {"kitchen", "office", "hall", "attic", "shop"}, DescriptorMatrix(5)};
  made.areByName = true;
  for (int i = 0; i < 4; ++i) made.probabilities.append(std::vector<float>{0.8F, 0.05F, 0.05F, 0.05F, 0.05F});
  const std::vector<std::size_t> groupOf{0, 0, 1, 1};
  const auto sure = [&](GroupedBy by = GroupedBy::space) {
    return areSureRooms(made, groupOf, poolRooms(made, groupOf, 3), by);
  };
  EXPECT_THAT(sure(), ElementsAre(true, true, false)) << "judged by the probability alone; none in the last";
  // log(0.8 / 0.05) = 2.77 is the evidence of all labels; in the first group one label gives it in both
  // images.
  made.evidence = {{0, 7, {2.5F, 0, 0, 0, 0}},
                   {1, 7, {2.5F, 0, 0, 0, 0}},
                   {2, 7, {2.5F, 0, 0, 0, 0}},
                   {3, 8, {2.5F, 0, 0, 0, 0}},
                   {9, 8, {2.5F, 0, 0, 0, 0}}};
  EXPECT_THAT(sure(), ElementsAre(false, true, false)) << "two labels, each in half of the images";
  EXPECT_THAT(sure(GroupedBy::labels), ElementsAre(true, true, false)) << "it stays the best one";
  for (RoomEvidence& told : made.evidence) told.logOdds[4] = -1;
  EXPECT_THAT(sure(GroupedBy::labels), ElementsAre(false, true, false)) << "the shop is better without it";
  for (RoomEvidence& told : made.evidence) told.logOdds.assign(5, 2.5F);
  EXPECT_THAT(sure(), ElementsAre(true, true, false)) << "what tells for all rooms tells nothing";
}

TEST(SameWords, DoNotMindCaseHyphensAndPlurals) {
  EXPECT_TRUE(sameWords("dining_room", "Dining rooms"));
  EXPECT_TRUE(sameWords("Kitchen", "kitchens"));
  EXPECT_FALSE(sameWords("kitchen", "kitchen table"));
  EXPECT_FALSE(sameWords("", ""));
  EXPECT_FALSE(sameWords("room 1", "room 2"));
}

std::vector<double> pooled(const std::vector<std::vector<float>>& opinions) {
  LogOpinionPool pool(opinions.front().size());
  for (const auto& opinion : opinions) pool.add(opinion);
  return pool.pooled();
}

TEST(LogOpinionPool, IsTheScaledGeometricMeanInWhichAZeroIsNoProof) {
  // sqrt(0.5 · 0.02) = 0.1, sqrt(0.5 · 0.98) = 0.7
  EXPECT_THAT(pooled({{0.5F, 0.5F}, {0.02F, 0.98F}}),
              ElementsAre(testing::DoubleNear(0.125, 1e-6), testing::DoubleNear(0.875, 1e-6)));
  EXPECT_GT(pooled({{0, 1}, {0.999F, 0.001F}, {0.999F, 0.001F}})[0], 0.5);
  LogOpinionPool pool(2);
  pool.add(std::vector<float>{0, 0});
  EXPECT_EQ(pool.size(), 0U);
  EXPECT_THAT(pool.pooled(), IsEmpty());
  EXPECT_THAT([&] { pool.add(std::vector<float>{1}); }, FailsWith(ErrorCode::mismatch));
}

/// The sizes of the segments of frames of these names.
std::vector<std::size_t> lengths(const std::vector<std::string>& names,
                                 const std::vector<std::string>& places,
                                 const std::vector<double>& times = {}) {
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < names.size(); ++i) {
    Frame& frame = frames.emplace_back();
    frame.name = names[i];
    if (i < times.size()) frame.timestamp = times[i];
  }
  std::vector<std::size_t> sizes;
  std::size_t next = 0;
  for (const TemporalSegment& segment : temporalSegments(frames, places)) {
    EXPECT_EQ(segment.first, next);
    next += segment.size;
    sizes.push_back(segment.size);
  }
  EXPECT_EQ(next, names.size());
  return sizes;
}

std::vector<std::string> all(std::size_t frames) {
  return std::vector<std::string>(frames, "a");
}

TEST(TemporalSegments, EndWhereThePlaceChangesAndWhereNumbersOrTimesLeaveOutMoreThanUsual) {
  EXPECT_THAT(lengths({"one.png", "two.png", "three.png", "four.png"}, {"a", "a", "b", "a"}),
              ElementsAre(2, 1, 1));
  EXPECT_THAT(lengths({}, {}), ElementsAre());
  EXPECT_THAT(lengths({"0001.png", "0002.png", "0003.png", "0005.png", "0006.png"}, all(5)),
              ElementsAre(3, 2));
  EXPECT_THAT(lengths({"frame000001.jpg", "frame000002.jpg", "frame000003.jpg", "frame000009.jpg"}, all(4)),
              ElementsAre(3, 1));
  EXPECT_THAT(lengths({"7.png", "8.png", "9.png", "1.png", "2.png"}, all(5)), ElementsAre(3, 2))
      << "they fall";
}

TEST(TemporalSegments, FractionsAreNoNumbersOfFramesButTimesEndThem) {
  EXPECT_THAT(lengths({"1305031102.175304.png", "1305031102.211214.png", "1305031102.943223.png",
                       "1305031103.011215.png"},
                      all(4)),
              ElementsAre(4));
  EXPECT_THAT(lengths({"5.275304.png", "5.311214.png", "5.943223.png"}, all(3)), ElementsAre(3))
      << "though the text before the digits is the same";
  EXPECT_THAT(lengths({"t1_x-1.25_a0.7185.jpg", "t2_x-1.26_a0.0012.jpg", "t3_x-1.27_a2.5.jpg"}, all(3)),
              ElementsAre(3));
  EXPECT_THAT(lengths({"1.png", "2.png", "other.png", "90.png"}, all(4)), ElementsAre(4))
      << "not all are numbers";
  const std::string long1(40, '1'), long2(40, '9');
  EXPECT_THAT(lengths({long1, long2}, all(2)), ElementsAre(2)) << "too long for a number";
  // Two rounds of a robot; the clock jitters, and names carry no information.
  EXPECT_THAT(lengths({"9", "3", "7", "1", "2"}, all(5), {0, 0.2, 0.55, 60, 60.2}), ElementsAre(3, 2));
  EXPECT_THAT(lengths({"1", "2", "3", "4"}, all(4), {10, 11, 1, 2}), ElementsAre(2, 2)) << "it falls";
  EXPECT_THAT(lengths({"1", "2", "7", "8"}, all(4), {10, 11, 12}), ElementsAre(2, 2)) << "one has no time";
}

}  // namespace
}  // namespace estancia
