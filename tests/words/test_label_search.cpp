// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/label_words.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

/// Things of a home and of the street, a few with synonyms.
const Vocabulary& things() {
  static const Vocabulary vocabulary({"coffee mug",
                                      "espresso maker",
                                      "sofa, couch, lounge",
                                      "folding chair",
                                      "desk",
                                      "ambulance",
                                      "minivan",
                                      "mountain bike, all-terrain bike, off-roader",
                                      "golden retriever",
                                      "tabby, tabby cat",
                                      "stove",
                                      "refrigerator, icebox",
                                      "microwave, microwave oven",
                                      "dishwasher",
                                      "washer, automatic washer, washing machine",
                                      "cleaver, meat cleaver",
                                      "umbrella",
                                      "pillow",
                                      "toilet tissue, toilet paper",
                                      "bookcase",
                                      "acoustic guitar",
                                      "banana",
                                      "milk can",
                                      "crane",
                                      "crane",
                                      "lakeside, lakeshore"});
  return vocabulary;
}

const LabelSearch& search() {
  static const LabelSearch labels(things(), &test::realWords());
  return labels;
}

/// Short labels, best first.
std::vector<std::string> found(std::string_view words) {
  std::vector<std::string> labels;
  for (const LabelMatch& match : search().search(words).labels)
    labels.push_back(shortLabel(things()[match.label]));
  return labels;
}

std::string reasonOf(std::string_view words, const std::string& label) {
  for (const LabelMatch& match : search().search(words).labels)
    if (shortLabel(things()[match.label]) == label) return match.reason;
  return "(not found)";
}

TEST(LabelSearch, GivesLabelsOfThatNameAlone) {
  EXPECT_THAT(found("coffee mug"), ElementsAre("coffee mug"));
  EXPECT_THAT(found("Couch"), ElementsAre("sofa"));
  EXPECT_THAT(found("washing-machines"), ElementsAre("washer"));
  EXPECT_THAT(found("crane"), ElementsAre("crane", "crane"));
  const LabelMatches matches = search().search("desk");
  ASSERT_EQ(matches.labels.size(), 1U);
  EXPECT_EQ(matches.labels.front().probability, 1);
  EXPECT_EQ(matches.labels.front().reason, "");
  EXPECT_EQ(matches.corrected, "");
}

TEST(LabelSearch, FindsKindsOfThings) {
  EXPECT_THAT(found("vehicle"), testing::IsSupersetOf({"ambulance", "minivan", "mountain bike"}));
  EXPECT_THAT(found("vehicle"), Not(Contains("sofa")));
  EXPECT_THAT(found("furniture"), testing::IsSupersetOf({"sofa", "folding chair", "desk", "bookcase"}));
  EXPECT_THAT(found("animals"), testing::IsSupersetOf({"golden retriever", "tabby"}));
  EXPECT_EQ(reasonOf("furniture", "desk"), "a kind of furniture");
  EXPECT_EQ(reasonOf("vehicles", "minivan"), "a kind of vehicle");
  EXPECT_EQ(reasonOf("dog's", "golden retriever"), "a kind of dog");
}

TEST(LabelSearch, FindsWhatServesAPurpose) {
  EXPECT_THAT(found("cook"), Contains("stove"));
  EXPECT_THAT(found("something to wash dishes"), Contains("dishwasher"));
  EXPECT_EQ(found("sleep").front(), "pillow");
  EXPECT_THAT(found("something to sit on"), testing::IsSupersetOf({"folding chair", "sofa"}));
  EXPECT_EQ(reasonOf("something to sit on", "folding chair"), "its purpose is to sit");
  EXPECT_EQ(reasonOf("sitting", "folding chair"), "its purpose is sitting");
}

TEST(LabelSearch, FindsWhatStandsInARoom) {
  EXPECT_THAT(found("kitchen"), testing::AnyOf(Contains("stove"), Contains("refrigerator")));
  EXPECT_THAT(found("kitchen"), Not(Contains("golden retriever")));
}

TEST(LabelSearch, FindsWhatDefinitionsName) {
  EXPECT_THAT(found("coffee"), testing::UnorderedElementsAre("coffee mug", "espresso maker"));
  EXPECT_EQ(found("kitchen knife").front(), "cleaver");
}

TEST(LabelSearch, FindsMisspelledWordsAndTellsWhatItLookedFor) {
  EXPECT_THAT(found("refridgerator"), Contains("refrigerator"));
  EXPECT_EQ(search().search("vehicel").corrected, "vehicle");
  EXPECT_EQ(search().search("vehicle").corrected, "");
  EXPECT_EQ(search().search("musical instrment").corrected, "musical instrument");
}

TEST(LabelSearch, OrdersByProbability) {
  double last = 1;
  for (const LabelMatch& match : search().search("vehicle").labels) {
    EXPECT_LE(match.probability, last);
    EXPECT_GE(match.probability, LabelSearch::defaultMinProbability);
    last = match.probability;
  }
  EXPECT_EQ(search().search("vehicle", 2).labels.size(), 2U);
  EXPECT_THAT(search().search("vehicle", 0).labels, IsEmpty());
}

TEST(LabelSearch, KnowsNothingOfWordsThatMeanNothing) {
  for (const std::string& words :
       {std::string(), std::string("the of"), std::string("a"), std::string("xyzzy"), std::string(10000, 'x'),
        std::string("椅子"), std::string("\x01\x02\x1b[31m"), std::string("\xff\xfe\x80"),
        std::string(1, '\0'), std::string("%s%n")}) {
    const LabelMatches matches = search().search(words);
    EXPECT_THAT(matches.labels, IsEmpty()) << words.substr(0, 40);
    EXPECT_EQ(matches.corrected, "") << words.substr(0, 40);
    EXPECT_THAT(search().probabilities(words), Each(0.0)) << words.substr(0, 40);
  }
}

TEST(LabelSearch, MatchesNamesWithoutAGraph) {
  const LabelSearch plain(things(), nullptr);
  for (const char* words :
       {"coffee mug", "couch", "chair", "crane", "cup", "vehicle", "", "xyzzy", "red umbrella"}) {
    std::vector<std::size_t> labels;
    for (const LabelMatch& match : plain.search(words).labels) labels.push_back(match.label);
    EXPECT_EQ(labels, findLabels(things(), words)) << words;
    EXPECT_EQ(plain.search(words).corrected, "");
  }
  EXPECT_THAT(plain.probabilities("coffee"), Each(0.0));
}

TEST(LabelSearch, LooksIntoEachModelOfSeveral) {
  const auto models = test::findTestModels();
  ESTANCIA_NEEDS(models, "the test models are missing");
  std::vector<std::string> labels = readVocabulary(*models / "imagenet_1001.txt").labels();
  const Vocabulary coco =
      readVocabulary(std::filesystem::path(ESTANCIA_SOURCE_DIR) / "models/coco-ssd/labels.txt");
  labels.insert(labels.end(), coco.labels().begin(), coco.labels().end());
  const Vocabulary both(labels, {{1001, 1}, {coco.size(), 1}});
  const LabelSearch several(both, &test::realWords());
  const auto namesOf = [&](const char* words) {
    std::vector<std::string> names;
    for (const LabelMatch& match : several.search(words).labels)
      names.push_back(shortLabel(both[match.label]) + (match.label < 1001 ? "" : " of COCO"));
    return names;
  };
  EXPECT_THAT(namesOf("banana"), ElementsAre("banana", "banana of COCO"));
  EXPECT_EQ(namesOf("dog").front(), "dog of COCO");
  EXPECT_THAT(namesOf("dog"), testing::SizeIs(testing::Gt(100))) << "and all breeds of ImageNet";
  EXPECT_THAT(namesOf("bed"), Not(Contains("pillow"))) << "which belongs to it and is none";
  EXPECT_EQ(several.probabilities("vehicle").front(), 0) << "the background means nothing";
}

TEST(LabelSearch, ReadsCompoundsThatAreWrittenApart) {
  const LabelMatches apart = search().search("book case");
  EXPECT_EQ(shortLabel(things()[apart.labels.at(0).label]), "bookcase");
  EXPECT_EQ(apart.corrected, "bookcase");
  EXPECT_EQ(search().search("meat cleaver").corrected, "") << "known together";
  EXPECT_EQ(search().search("the book case of Ana").corrected, "the bookcase of ana");
}

TEST(LabelSearch, KnowsCommonRoomsByOtherWords) {
  const auto reasonsFor = [](std::string_view words) {
    std::vector<std::string> reasons;
    for (const LabelMatch& match : search().search(words).labels) reasons.push_back(match.reason);
    return reasons;
  };
  EXPECT_THAT(reasonsFor("sitting room"), Contains("usual in a living room"));
  EXPECT_THAT(reasonsFor("the kitchen"), Contains("usual in a kitchen"));
  EXPECT_THAT(reasonsFor("office"), Contains("usual in an office"));
}

}  // namespace
}  // namespace estancia
