// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_search.hpp"
#include "estancia/words/word_associations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "estancia/core/label_words.hpp"
#include "estancia/words/word_files.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using Meant = WordAssociation::Meant;
using test::FailsWith;
using testing::Contains;
using testing::ElementsAre;

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
  EXPECT_THAT(found("vehicle"), testing::Not(Contains("sofa")));
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

TEST(LabelSearch, FindsWhatStandsInARoomAndWhatDefinitionsName) {
  EXPECT_THAT(found("kitchen"), testing::AnyOf(Contains("stove"), Contains("refrigerator")));
  EXPECT_THAT(found("kitchen"), testing::Not(Contains("golden retriever")));
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
  EXPECT_THAT(search().search("vehicle", 0).labels, testing::IsEmpty());
}

TEST(LabelSearch, KnowsNothingOfWordsThatMeanNothing) {
  for (const std::string& words :
       {std::string(), std::string("the of"), std::string("a"), std::string("xyzzy"), std::string(10000, 'x'),
        std::string("椅子"), std::string("\x01\x02\x1b[31m"), std::string("\xff\xfe\x80"),
        std::string(1, '\0'), std::string("%s%n")}) {
    const LabelMatches matches = search().search(words);
    EXPECT_THAT(matches.labels, testing::IsEmpty()) << words.substr(0, 40);
    EXPECT_EQ(matches.corrected, "") << words.substr(0, 40);
    EXPECT_THAT(search().probabilities(words), testing::Each(0.0)) << words.substr(0, 40);
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
  EXPECT_THAT(plain.probabilities("coffee"), testing::Each(0.0));
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
  EXPECT_THAT(namesOf("bed"), testing::Not(Contains("pillow"))) << "which belongs to it and is none";
  EXPECT_EQ(several.probabilities("vehicle").front(), 0) << "the background means nothing";
}

TEST(LabelSearch, ReadsCompoundsThatAreWrittenApart) {
  const LabelMatches apart = search().search("book case");
  EXPECT_EQ(shortLabel(things()[apart.labels.at(0).label]), "bookcase");
  EXPECT_EQ(apart.corrected, "bookcase");
  EXPECT_EQ(search().search("meat cleaver").corrected, "") << "known together";
  EXPECT_THAT(found("tooth of book case a it case s"), Contains("bookcase"));
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

/// Labels of two models: each has its own best label for a word.
const Vocabulary& homeLabels() {
  static const Vocabulary labels(
      {"coffee mug", "espresso maker", "studio couch, day bed", "folding chair", "desk", "minivan",
       "golden retriever", "stove", "refrigerator, icebox", "microwave, microwave oven", "bookcase",
       "toilet seat", "refrigerator", "chair", "couch", "bed", "zzz qqq"},
      {{12}, {5}});
  return labels;
}

const std::vector<WordAssociation>& homeAssociations() {
  static const std::vector<WordAssociation> all = associateWords(test::realWords(), homeLabels());
  return all;
}

std::string namesFor(const std::string& word) {
  const auto found = std::ranges::find(homeAssociations(), word, &WordAssociation::word);
  if (found == homeAssociations().end()) return "unknown";
  std::string names;
  for (const Meant& meant : found->labels) names += (names.empty() ? "" : "|") + homeLabels()[meant.label];
  return names;
}

std::string expectedNames(const LabelSearch& search, const std::string& word) {
  std::vector<Meant> meant;
  const std::vector<double> probabilities = search.likely(word);
  for (std::uint32_t label = 0; label < probabilities.size(); ++label)
    if (probabilities[label] > 0)
      meant.push_back({label, static_cast<std::uint8_t>(std::lround(100 * probabilities[label]))});
  std::ranges::stable_sort(meant, std::greater(), &Meant::percent);
  std::string names;
  for (const Meant& one : meant) names += (names.empty() ? "" : "|") + homeLabels()[one.label];
  return names;
}

TEST(WordAssociations, AreWhatLabelSearchFinds) {
  const LabelSearch search(homeLabels(), &test::realWords());
  for (const char* word : {"coffee", "kitchen", "living room", "sit", "sleep", "vehicle", "furniture", "cook",
                           "democracy", "dogs", "mice", "big", "fridge", "bedroom", "beverage", "read"}) {
    if (namesFor(word) == "unknown")
      EXPECT_EQ(word, std::string("dogs")) << "a regular plural is no entry";
    else
      EXPECT_EQ(namesFor(word), expectedNames(search, word)) << word;
  }
  for (std::size_t i = 0; i < homeAssociations().size(); i += homeAssociations().size() / 40) {
    const WordAssociation& association = homeAssociations()[i];
    const std::vector<double> probabilities = search.probabilities(association.word);
    EXPECT_EQ(namesFor(association.word), expectedNames(search, association.word)) << association.word;
    for (const Meant& meant : association.labels)
      EXPECT_NEAR(meant.percent / 100.0, probabilities[meant.label], 0.0051) << association.word;
  }
}

TEST(WordAssociations, AreSelectedByLabelAndWorth) {
  const std::vector<WordAssociation> all{{"bed", true, {{0, 90}, {1, 80}, {2, 40}}},
                                         {"cot", false, {{0, 49}, {1, 45}}},
                                         {"idea", true, {}},
                                         {"litter", false, {{2, 70}, {1, 60}}}};
  const auto isFirstTwo = [](const std::string&, std::uint32_t label) { return label < 2; };
  const auto two = selectAssociations(all, isFirstTwo);
  EXPECT_EQ(two, (std::vector<WordAssociation>{
                     {"bed", true, {{0, 90}, {1, 80}}}, {"idea", true, {}}, {"litter", false, {{1, 60}}}}));
  AssociationLimits limits;
  limits.minRarePercent = 61;
  limits.maxLabels = 1;
  EXPECT_EQ(selectAssociations(all, isFirstTwo, limits),
            (std::vector<WordAssociation>{{"bed", true, {{0, 90}}}, {"idea", true, {}}}));
}

// Unpacks like word_search.js.
std::vector<WordAssociation> unpacked(const PackedAssociations& packed) {
  const auto number = [](const std::string& digits) { return std::stoul(digits, nullptr, 36); };
  std::vector<WordAssociation> all;
  std::string word;
  const std::regex entry("([0-9A-Z])([a-z' ]+)((?:[0-9A-Z]{4})*)");
  for (std::sregex_iterator at(packed.text.begin(), packed.text.end(), entry), end; at != end; ++at) {
    word = word.substr(0, number((*at)[1])) + (*at)[2].str();
    all.push_back({word, true, {}});
    const std::string list = (*at)[3];
    for (std::size_t i = 0; i < list.size(); i += 4)
      all.back().labels.push_back({packed.labels.at(number(list.substr(i, 2))),
                                   static_cast<std::uint8_t>(number(list.substr(i + 2, 2)))});
  }
  return all;
}

TEST(PackedAssociations, BringWordsAndLabelsBackAndRefuseWhatCannotBeRead) {
  const std::vector<WordAssociation> all{{"bed", true, {{7, 100}, {1400, 30}}},
                                         {"bed's head", true, {}},
                                         {"bedroom", true, {{7, 35}, {8, 36}, {9, 37}}},
                                         {"coffee", true, {{1400, 99}}},
                                         {"z", true, {}}};
  const PackedAssociations packed = packAssociations(all);
  EXPECT_THAT(packed.labels, ElementsAre(7, 8, 9, 1400));
  EXPECT_EQ(unpacked(packed), all);
  EXPECT_EQ(packAssociations({}).text, "");
  std::vector<WordAssociation> real = homeAssociations();
  for (WordAssociation& association : real) association.isFrequent = true;  // not packed
  EXPECT_EQ(unpacked(packAssociations(real)), real);
  for (const char* word : {"Bed", "b3d", "bed</script>", "caf\xC3\xA9", "a\"b", "", "bed"}) {
    const std::vector<WordAssociation> bad{{"bed", true, {}}, {word, true, {}}};
    EXPECT_THAT([&] { packAssociations(bad); }, FailsWith(ErrorCode::invalidInput)) << word;
  }
  WordAssociation many{"bed", true, {}};
  for (std::uint32_t label = 0; label < 1296; ++label) many.labels.push_back({label, 50});
  EXPECT_EQ(packAssociations({many}).labels.size(), 1296U);
  many.labels.push_back({1296, 50});
  EXPECT_THAT([&] { packAssociations({many}); }, FailsWith(ErrorCode::invalidInput));
}

TEST(WordAssociationsFile, BringsThemBackAndRefusesWhatIsDamaged) {
  const std::vector<WordAssociation> few{{"bed", true, {{1, 90}}}, {"chair", false, {{2, 50}, {0, 40}}}};
  const std::string bytes = packAssociationsFile(few, "labels");
  const auto reading = [](const std::string& text, const char* source, std::size_t labels) {
    return [=] { unpackAssociationsFile(text, source, labels, "a.words"); };
  };
  EXPECT_NO_THROW(reading(bytes, "labels", 3)());
  EXPECT_THAT(reading(bytes, "other", 3), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(reading(bytes, "labels", 2), FailsWith(ErrorCode::corruptFile));
  EXPECT_THAT(reading("no such file", "labels", 3), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(reading(bytes + "x", "labels", 3), FailsWith(ErrorCode::corruptFile));
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    EXPECT_THROW(reading(bytes.substr(0, at), "labels", 3)(), Error) << at;
    for (const char damage : {'\xff', '\x7f', '\x01', 'Z'}) {
      std::string changed = bytes;
      changed[at] = damage;
      const auto code = test::caught(reading(changed, "labels", 3)).code;
      EXPECT_TRUE(at >= 12 || changed == bytes || code) << "in the head, byte " << at;
    }
  }
  const std::string upward = packAssociationsFile({few[1], few[0]}, "labels");
  EXPECT_THAT(reading(upward, "labels", 3), FailsWith(ErrorCode::corruptFile)) << "not sorted";
  const std::string all = packAssociationsFile(homeAssociations(), "labels");
  EXPECT_EQ(unpackAssociationsFile(all, "labels", homeLabels().size(), "a.words"), homeAssociations());
}

TEST(WordFilter, HasTheBitsOfAnIndependentOne) {
  EXPECT_EQ(packWordFilter({"bedsit", "hoover", "kitchen", "nappy", "zumba"}), "pUM10R1VVw==")
      << "computed by a script of the same description in another language";
  EXPECT_EQ(packWordFilter({}), "");
}

TEST(LabelSearch, ReadsTheBeginningOfALongText) {
  EXPECT_EQ(found("coffee " + std::string(10000, 'x')), found("coffee"));
  EXPECT_EQ(found("coffee\x01" + std::string(10000, ' ')), found("coffee"));
  std::string many = "coffee", garbage = "coffee";
  for (int i = 0; i < 60; ++i) many += " coffee the", garbage += " qwrtpsdf" + std::string(1, 'a' + i % 26);
  EXPECT_EQ(found(many), found("coffee")) << "said again";
  EXPECT_EQ(found(garbage), found("coffee")) << "words that mean nothing";
}

}  // namespace
}  // namespace estancia
