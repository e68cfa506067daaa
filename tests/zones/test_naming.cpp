// Names for zones: words that tell them apart.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/naming.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "estancia/zones/zones.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

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

TEST(ZoneNames, NameAWordThatTheVocabularyHoldsTwiceOnce) {
  const std::vector<float> run{0.5F, 0.1F, 0.1F, 0.1F, 0.1F, 0.1F};
  EXPECT_THAT(nameZones(words, {{0, 0, 0, 0.3F, 0.4F, 0.3F}}, run), ElementsAre("crane, tub"));
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
