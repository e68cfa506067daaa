// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/familiar_words.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "words/real_words.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;
using testing::FloatEq;
using testing::IsEmpty;

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

TEST(FamiliarWords, StandForSeveralLabels) {
  const std::vector<float> mean{0.14F, 0.2F, 0.11F, 0.2F, 0.15F, 0.05F, 0.12F, 0.3F, 0.2F, 0.01F};
  const std::vector<FamiliarWord> words = familiarWords(labels(), concepts(), mean, 4);
  EXPECT_THAT(namesOf(words), ElementsAre("couch", "dog", "refrigerator", "desk"));
  EXPECT_THAT(words[0].probability, FloatEq(0.5F));
  EXPECT_THAT(words[0].labels, ElementsAre(7, 3)) << "the most probable first";
  EXPECT_THAT(words[1].probability, FloatEq(0.45F));
  EXPECT_THAT(words[2].labels, ElementsAre(8, 6)) << "the same name";
  EXPECT_THAT(namesOf(familiarWords(labels(), {}, mean, 4)),
              ElementsAre("couch", "golden retriever", "studio couch", "refrigerator"))
      << "raw";
}

TEST(FamiliarWords, NoiseOfManyLabelsIsNoWord) {
  const std::vector<float> mean{0.009F, 0.009F, 0.009F, 0, 0.02F, 0, 0, 0, 0, 0.02F};
  EXPECT_THAT(namesOf(familiarWords(labels(), concepts(), mean, 2)), ElementsAre("desk", "stone"));
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
