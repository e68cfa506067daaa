// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_concepts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "estancia/core/label_words.hpp"
#include "estancia/words/label_senses.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using test::realWords;
using testing::ElementsAre;

/// The byte offset of the most probable meaning, as ImageNet numbers it; 0: none.
std::uint32_t numberOf(const LabelSense& label) {
  return label.senses.empty() ? 0 : realWords().offsets[label.senses.front().synset];
}

std::string nameOf(const LabelSense& label) {
  return label.senses.empty() ? "" : std::string(realWords().name(label.senses.front().synset));
}

Vocabulary testVocabulary(const char* file) {
  return readVocabulary(*test::findTestModels() / file);
}

class ImageNetSenses : public testing::TestWithParam<const char*> {};

TEST_P(ImageNetSenses, AreTheSynsetsOfTheirOrder) {
  ESTANCIA_NEEDS(test::findTestModels(), "the test models are missing");
  const Vocabulary vocabulary = testVocabulary(GetParam());
  const std::size_t background = vocabulary.size() - 1000;
  const std::vector<LabelSense> senses = findLabelSenses(realWords(), vocabulary);
  ASSERT_EQ(senses.size(), vocabulary.size());
  for (std::size_t i = 0; i < 1000; ++i) {
    const LabelSense& label = senses[i + background];
    ASSERT_EQ(label.senses.size(), 1U);
    EXPECT_EQ(numberOf(label), imageNetSynsets().at(i));
    EXPECT_FLOAT_EQ(label.senses.front().probability, 1);
    EXPECT_FALSE(label.isDoubtful);
    const std::vector<Sense> meant = realWords().lexicon.senses(shortLabel(vocabulary[i + background]));
    EXPECT_TRUE(std::any_of(meant.begin(), meant.end(),
                            [&](const Sense& sense) { return sense.synset == label.senses.front().synset; }))
        << vocabulary[i + background] << " is none of " << nameOf(label);
  }
  if (background == 1) {
    EXPECT_TRUE(senses.front().senses.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(LabelSenses, ImageNetSenses,
                         testing::Values("imagenet_1000.txt", "imagenet_1001.txt"),
                         [](const auto& file) { return std::string(file.param).substr(0, 13); });

TEST(LabelSenses, OfCocoAreThings) {
  const Vocabulary vocabulary =
      readVocabulary(std::filesystem::path(ESTANCIA_SOURCE_DIR) / "models/coco-ssd/labels.txt");
  const std::vector<LabelSense> senses = findLabelSenses(realWords(), vocabulary);
  const auto of = [&](const std::string& label) {
    const auto& labels = vocabulary.labels();
    return senses.at(
        static_cast<std::size_t>(std::find(labels.begin(), labels.end(), label) - labels.begin()));
  };
  for (const LabelSense& label : senses) EXPECT_FALSE(label.senses.empty());
  EXPECT_EQ(nameOf(of("tv")), "television receiver") << "not the medium";
  EXPECT_EQ(nameOf(of("couch")), "sofa");
  EXPECT_EQ(nameOf(of("sports ball")), "ball");
  EXPECT_TRUE(of("sports ball").isDoubtful) << "WordNet has only its words";
  EXPECT_FALSE(of("refrigerator").isDoubtful);
  for (const char* food : {"hot dog", "orange"})
    EXPECT_EQ(realWords().category(of(food).senses.front().synset), WordCategory::food) << food;
  for (const char* thing : {"wine glass", "microwave"})
    EXPECT_EQ(realWords().category(of(thing).senses.front().synset), WordCategory::artifact) << thing;
}

TEST(LabelSenses, OfPlacesAreThePlaceNotItsQualifier) {
  ESTANCIA_NEEDS(test::findTestModels(), "the test models are missing");
  const Vocabulary vocabulary = testVocabulary("places_365.txt");
  const std::vector<LabelSense> senses = findLabelSenses(realWords(), vocabulary);
  std::size_t doubtful = 0, unknown = 0;
  for (std::size_t i = 0; i < vocabulary.size(); ++i) {
    doubtful += senses[i].isDoubtful;
    unknown += senses[i].senses.empty();
    for (const auto& [label, name] : {std::pair{"temple/asia", "temple"},
                                      {"moat/water", "moat"},
                                      {"balcony/exterior", "balcony"},
                                      {"lake/natural", "lake"},
                                      {"atrium/public", "atrium"},
                                      {"living_room", "living room"},
                                      {"mansion", "mansion"},
                                      {"church/indoor", "church"},
                                      {"computer_room", "room"}})
      if (vocabulary[i] == label) {
        EXPECT_EQ(nameOf(senses[i]), name) << label;
      }
  }
  EXPECT_LE(doubtful, 70U);
  EXPECT_LE(unknown, 1U);
}

constexpr std::size_t all = 100;

const std::vector<std::string> breeds{"Labrador retriever", "golden retriever", "beagle",
                                      "Pekinese, Pekingese, Peke", "German shepherd, German police dog"};
const std::vector<std::string> kitchen{"stove", "refrigerator, icebox", "microwave, microwave oven",
                                       "dishwasher"};
const std::vector<std::string> birds{"robin, American robin, Turdus migratorius", "jay", "magpie", "vulture"};

Vocabulary vocabularyOf(std::initializer_list<std::vector<std::string>> lists) {
  std::vector<std::string> labels;
  for (const auto& list : lists) labels.insert(labels.end(), list.begin(), list.end());
  return Vocabulary(labels);
}

std::vector<std::string> namesOf(const std::vector<TellingWord>& words) {
  std::vector<std::string> names;
  for (const TellingWord& word : words) names.push_back(word.name);
  return names;
}

/// Distinctive words of a part of a run in which all labels are equally likely.
std::vector<std::string> toldBy(const Vocabulary& vocabulary, const std::vector<float>& here,
                                std::size_t count = all) {
  const std::vector<float> run(vocabulary.size(), 1.0F / static_cast<float>(vocabulary.size()));
  return namesOf(tellingWords(vocabulary, findLabelConcepts(realWords(), vocabulary), here, run, count));
}

TEST(LabelConcepts, AreOnTheLevelOnWhichPeopleNameThings) {
  const Vocabulary vocabulary = vocabularyOf({breeds, kitchen, birds, {"desk", "bookcase", "wardrobe"}});
  std::vector<std::string> names;
  for (const LabelConcept& named : findLabelConcepts(realWords(), vocabulary)) {
    names.push_back(named.name);
    EXPECT_GT(named.specificity, 0);
    EXPECT_LE(named.specificity, 1);
    EXPECT_TRUE(std::ranges::includes(named.covered, named.labels)) << named.name;
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("dog", "bird"))
      << "no retriever, animal, appliance, furniture or artifact";
}

TEST(LabelConcepts, LeaveFamiliarLabelsToThemselves) {
  const LabelConcepts concepts = findLabelConcepts(realWords(), vocabularyOf({birds}));
  ASSERT_EQ(concepts.size(), 1U);
  EXPECT_THAT(concepts.front().labels, ElementsAre(0, 1, 2));
  EXPECT_THAT(concepts.front().covered, ElementsAre(0, 1, 2, 3)) << "a vulture is a bird, too";
}

TEST(LabelConcepts, AreNoneOfLabelsThatWordNetDoesNotKnow) {
  const Vocabulary vocabulary(
      {"xyzzy", "Labrador retriever", "label 17", "\x01\xff", ", ,", "n02099712", std::string(10000, 'x')});
  EXPECT_THAT(findLabelConcepts(realWords(), vocabulary), testing::IsEmpty());
  EXPECT_EQ(toldBy(vocabulary, std::vector<float>(7, 0.15F)).size(), 7U);
}

TEST(TellingWords, NameFiveBreedsADogButKeepWhatTellsMoreAndNothingCovered) {
  EXPECT_THAT(toldBy(vocabularyOf({breeds, kitchen}), {0.2F, 0.15F, 0.2F, 0.15F, 0.13F, 0.15F, 0, 0, 0}),
              ElementsAre("dog", "stove"));
  EXPECT_THAT(toldBy(vocabularyOf({breeds, kitchen}), {0.7F, 0.12F, 0.0F, 0, 0, 0, 0, 0, 0}),
              ElementsAre("Labrador retriever", "golden retriever"));
  EXPECT_THAT(toldBy(vocabularyOf({breeds, kitchen}), {0.3F, 0, 0, 0, 0, 0.2F, 0, 0, 0}),
              ElementsAre("Labrador retriever", "stove"))
      << "one breed does not compete";
  const Vocabulary vocabulary = vocabularyOf({birds, kitchen});
  EXPECT_THAT(toldBy(vocabulary, {0.27F, 0.27F, 0.27F, 0.15F, 0, 0, 0, 0}), ElementsAre("bird"));
  const auto vultures = toldBy(vocabulary, {0.17F, 0.17F, 0.17F, 0.45F, 0, 0, 0, 0});
  EXPECT_THAT(vultures, ElementsAre("vulture", "robin", "jay", "magpie"));
}

TEST(TellingWords, AreTheLabelsWithoutConcepts) {
  const Vocabulary vocabulary = vocabularyOf({breeds});
  const std::vector<float> run(5, 0.1F), here{0.2F, 0.3F, 0.3F, 0.1F, 0};
  EXPECT_THAT(namesOf(tellingWords(vocabulary, {}, here, run, all)),
              ElementsAre("golden retriever", "beagle", "Labrador retriever"))
      << "of equal ones the first";
  EXPECT_THAT(namesOf(tellingWords(vocabulary, {}, here, run, 2)), ElementsAre("golden retriever", "beagle"));
  EXPECT_THAT(tellingWords(vocabulary, {}, run, run, all), testing::IsEmpty());
}

const Vocabulary& labels() {
  static const Vocabulary vocabulary({"Labrador retriever", "golden retriever", "beagle",
                                      "studio couch, day bed", "desk", "stove", "refrigerator, icebox",
                                      "couch", "refrigerator", "stone"});
  return vocabulary;
}

const LabelConcepts& concepts() {
  static const LabelConcepts found = findLabelConcepts(test::realWords(), labels());
  return found;
}

std::vector<std::string> namesOf(const std::vector<FamiliarWord>& words) {
  std::vector<std::string> names;
  for (const FamiliarWord& word : words) names.push_back(word.name);
  return names;
}

TEST(FamiliarWords, StandForSeveralLabelsButNotForNoise) {
  const std::vector<float> mean{0.14F, 0.2F, 0.11F, 0.2F, 0.15F, 0.05F, 0.12F, 0.3F, 0.2F, 0.01F};
  const std::vector<FamiliarWord> words = familiarWords(labels(), concepts(), mean, 4);
  EXPECT_THAT(namesOf(words), ElementsAre("couch", "dog", "refrigerator", "desk"));
  EXPECT_THAT(words[0].probability, testing::FloatEq(0.5F));
  EXPECT_THAT(words[0].labels, ElementsAre(7, 3)) << "the most probable first";
  EXPECT_THAT(words[1].probability, testing::FloatEq(0.45F));
  EXPECT_THAT(words[2].labels, ElementsAre(8, 6)) << "the same name";
  EXPECT_THAT(namesOf(familiarWords(labels(), {}, mean, 4)),
              ElementsAre("couch", "golden retriever", "studio couch", "refrigerator"))
      << "raw";
  const std::vector<float> noise{0.009F, 0.009F, 0.009F, 0, 0.02F, 0, 0, 0, 0, 0.02F};
  EXPECT_THAT(namesOf(familiarWords(labels(), concepts(), noise, 2)), ElementsAre("desk", "stone"));
}

TEST(FamiliarTitle, IsWhatTellsThePlaceFromTheRun) {
  const std::vector<float> run(10, 0.1F);
  std::vector<float> here{0, 0, 0, 0.2F, 0.3F, 0.05F, 0.05F, 0.25F, 0.05F, 0.1F};
  EXPECT_EQ(familiarTitle(labels(), concepts(), here, run), "couch, desk");
  EXPECT_EQ(familiarTitle(labels(), {}, here, run), "desk") << "raw: the most probable label";
  EXPECT_EQ(familiarTitle(labels(), concepts(), run, run), "dog") << "nothing tells: the most probable";
}

}  // namespace
}  // namespace estancia
