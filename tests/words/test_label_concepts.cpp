// Label concepts: familiar words instead of several rare ones, and never instead of good ones.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_concepts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "words/real_words.hpp"

namespace estancia {
namespace {

using test::realWords;
using testing::ElementsAre;
using testing::IsEmpty;

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

/// Of a part of a run in which all labels are equally likely.
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
  EXPECT_THAT(findLabelConcepts(realWords(), vocabulary), IsEmpty());
  EXPECT_EQ(toldBy(vocabulary, std::vector<float>(7, 0.15F)).size(), 7U);
}

TEST(TellingWords, NameFiveBreedsADog) {
  EXPECT_THAT(toldBy(vocabularyOf({breeds, kitchen}), {0.2F, 0.15F, 0.2F, 0.15F, 0.13F, 0.15F, 0, 0, 0}),
              ElementsAre("dog", "stove"));
}

TEST(TellingWords, KeepALabelThatTellsMoreThanItsConcept) {
  EXPECT_THAT(toldBy(vocabularyOf({breeds, kitchen}), {0.7F, 0.12F, 0.0F, 0, 0, 0, 0, 0, 0}),
              ElementsAre("Labrador retriever", "golden retriever"));
  EXPECT_THAT(toldBy(vocabularyOf({breeds, kitchen}), {0.3F, 0, 0, 0, 0, 0.2F, 0, 0, 0}),
              ElementsAre("Labrador retriever", "stove"))
      << "one breed does not compete";
}

TEST(TellingWords, AreNotNamedBesideWhatTheyCover) {
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
  EXPECT_THAT(tellingWords(vocabulary, {}, run, run, all), IsEmpty());
}

}  // namespace
}  // namespace estancia
