#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "estancia/topology/ask.hpp"
#include "estancia/topology/words.hpp"
#include "support/support.hpp"
#include "topology/sample_map.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

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

TEST(FindLabels, KnowsSynonymsWhateverTheirCase) {
  EXPECT_THAT(found("MUG"), ElementsAre("cup, mug"));
  EXPECT_THAT(found(" tinca  Tinca "), ElementsAre("tench, Tinca tinca"));
  EXPECT_THAT(found("coffee mug"), ElementsAre("coffee mug"));
  EXPECT_THAT(found("Icebox"), ElementsAre("n04070727 refrigerator, icebox"));
  EXPECT_THAT(found("refrigerator"), ElementsAre("n04070727 refrigerator, icebox"));
  EXPECT_THAT(found("CAFÉ"), ElementsAre("Café"));
}

TEST(FindLabels, IgnoresHyphensAndUnderscores) {
  EXPECT_THAT(found("t shirt"), ElementsAre("T-shirt"));
  EXPECT_THAT(found("dining-room"), ElementsAre("dining_room"));
}

TEST(FindLabels, KnowsPlurals) {
  EXPECT_THAT(found("umbrellas"), ElementsAre("umbrella"));
  EXPECT_THAT(found("batteries"), ElementsAre("battery"));
  EXPECT_THAT(found("shelves"), ElementsAre("bookshelf, shelf"));
  EXPECT_THAT(found("gloves"), ElementsAre("glove"));
  EXPECT_THAT(found("buses"), ElementsAre("bus"));
  EXPECT_THAT(found("coffee mugs"), ElementsAre("coffee mug"));
}

TEST(FindLabels, FallsBackToWholeWordsInside) {
  EXPECT_THAT(found("table"), ElementsAre("dining table, board"));
  EXPECT_THAT(found("dining"), ElementsAre("dining table, board", "dining_room"));
  EXPECT_THAT(found("tab"), IsEmpty()) << "half a word is none";
  EXPECT_THAT(found("table dining"), IsEmpty());
}

TEST(FindLabels, FallsBackToTheLongestSynonymInside) {
  EXPECT_THAT(found("red umbrella"), ElementsAre("umbrella"));
  EXPECT_THAT(found("my coffee mug"), ElementsAre("coffee mug"));
}

TEST(FindLabels, FindsNothingInNothing) {
  EXPECT_THAT(found(""), IsEmpty());
  EXPECT_THAT(found(" ,;- "), IsEmpty());
  EXPECT_THAT(found("zebra"), IsEmpty());
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

TEST(Ask, RanksPlacesByProbability) {
  const Answers answers = ask(test::sampleMap(), "Umbrella");
  EXPECT_THAT(answers.labels, ElementsAre(3U));
  ASSERT_EQ(answers.places.size(), 3U);
  const PlaceAnswer& best = answers.places[0];
  EXPECT_EQ(best.node, 1);
  EXPECT_FLOAT_EQ(static_cast<float>(best.probability), 0.7F);
  EXPECT_EQ(best.rank, 1U);
  EXPECT_TRUE(best.amongBest5);
  // mean over the 7 images: (2·0.1 + 3·0.7 + 2·0) / 7
  EXPECT_NEAR(best.lift, 0.7 / (2.3 / 7), 1e-6);
  EXPECT_EQ(answers.places[1].node, 0);
  EXPECT_EQ(answers.places[1].rank, 4U);
  EXPECT_EQ(answers.places[2].node, 3);
  EXPECT_EQ(answers.places[2].rank, 5U);
  EXPECT_EQ(ask(test::sampleMap(), "umbrella", 1).places.size(), 1U);
}

TEST(Ask, TellsPlacesOutsideTheFiveBest) {
  TopologicalMap map{Vocabulary({"a", "b", "c", "d", "e", "f"}), "", "", {}, {}, {}, {}, {}};
  map.nodes = {test::nodeWith(0, 1, {0.1F, 0.2F, 0.2F, 0.2F, 0.2F, 0.2F})};
  EXPECT_EQ(ask(map, "a").places[0].rank, 6U);
  EXPECT_FALSE(ask(map, "a").places[0].amongBest5);
  EXPECT_TRUE(ask(map, "f").places[0].amongBest5);
}

TEST(Ask, AddsUpAllMatchingLabelsButNeverAboveOne) {
  TopologicalMap map{Vocabulary({"wine bottle", "water bottle", "desk"}), "", "", {}, {}, {}, {}, {}};
  map.nodes = {test::nodeWith(0, 1, {0.3F, 0.2F, 0.5F}), test::nodeWith(1, 1, {0.9F, 0.8F, 0.1F})};
  const Answers answers = ask(map, "bottles");
  EXPECT_THAT(answers.labels, ElementsAre(0U, 1U));
  EXPECT_EQ(answers.places[0].node, 1);
  EXPECT_DOUBLE_EQ(answers.places[0].probability, 1);
  EXPECT_NEAR(answers.places[1].probability, 0.5, 1e-6);
  EXPECT_EQ(answers.places[1].label, 0U);
  EXPECT_EQ(answers.places[1].rank, 2U);
}

TEST(Ask, SuggestsNearSpellings) {
  EXPECT_THAT(test::errorOf([] { ask(test::sampleMap(), "umbrela"); }),
              HasSubstr("none of the map's 5 labels matches \"umbrela\"; did you mean \"umbrella\"?"));
  EXPECT_THAT(test::errorOf([] { ask(test::sampleMap(), "xylophone"); }), HasSubstr("ask for another word"));
  EXPECT_THAT(test::errorOf([] { ask(test::sampleMap(), ""); }), HasSubstr("ask for another word"));
}

TEST(Ask, RefusesAnEmptyMap) {
  TopologicalMap map = test::sampleMap();
  map.nodes.clear();
  EXPECT_THAT(test::errorOf([&] { ask(map, "desk"); }), HasSubstr("the map has no places yet"));
}

}  // namespace
}  // namespace estancia
