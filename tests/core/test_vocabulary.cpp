// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/label_words.hpp"
#include "estancia/core/similar_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/vocabulary.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(Vocabulary, ReadsOneLabelALine) {
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
}

TEST(Vocabulary, RefusesAnEmptyLabel) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt", "cup\n\nmug\n");
  EXPECT_THAT([&] { readVocabulary(folder / "labels.txt"); }, FailsWith(ErrorCode::malformedFile));
  test::writeFile(folder / "labels.txt", "\r\n");
  EXPECT_THAT([&] { readVocabulary(folder / "labels.txt"); }, FailsWith(ErrorCode::malformedFile));
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
  for (const std::vector<LabelPart>& wrong :
       {std::vector<LabelPart>{{2, 1}}, {{2, 1}, {2, 1}}, {{3, 1}, {0, 1}}, {{2, 1}, {1, 0}}})
    EXPECT_THAT([&] { Vocabulary(labels, wrong); }, FailsWith(ErrorCode::invalidInput));
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

TEST(FindLabels, FallsBackToWholeWordsInside) {
  EXPECT_THAT(found("table"), ElementsAre("dining table, board"));
  EXPECT_THAT(found("dining"), ElementsAre("dining table, board", "dining_room"));
  EXPECT_THAT(found("tab"), IsEmpty()) << "half a word is none";
  EXPECT_THAT(found("table dining"), IsEmpty());
}

TEST(FindLabels, FallsBackToTheLongestSynonymInside) {
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

TEST(SimilarNames, DifferInCaseOrBlanksAtTheEnds) {
  EXPECT_TRUE(isSimilar("Kitchen", "kitchen"));
  EXPECT_TRUE(isSimilar(" kitchen\t", "kitchen"));
  EXPECT_FALSE(isSimilar("kitchen", "kitchen")) << "they are the same";
  EXPECT_FALSE(isSimilar("living room", "livingroom"));
  EXPECT_FALSE(isSimilar("", "kitchen"));
}

TEST(SimilarNames, AreToldTogether) {
  EXPECT_EQ(warningsOfSimilarRooms({"Kitchen", "bath", "kitchen", "kitchen "}).size(), 1U);
  EXPECT_TRUE(warningsOfSimilarRooms({"bath", "kitchen"}).empty());
}

}  // namespace
}  // namespace estancia
