// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_senses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "estancia/core/label_words.hpp"
#include "estancia/words/imagenet_synsets.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using test::realWords;

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
    EXPECT_EQ(numberOf(label), imageNetSynsets[i]);
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
  EXPECT_EQ(realWords().category(of("hot dog").senses.front().synset), WordCategory::food);
  EXPECT_EQ(realWords().category(of("orange").senses.front().synset), WordCategory::food);
  EXPECT_EQ(nameOf(of("couch")), "sofa");
  EXPECT_EQ(nameOf(of("toilet")), "toilet");
  EXPECT_EQ(nameOf(of("sports ball")), "ball");
  EXPECT_TRUE(of("sports ball").isDoubtful) << "WordNet has only its words";
  EXPECT_EQ(nameOf(of("cell phone")), "telephone");
  EXPECT_EQ(nameOf(of("toaster")), "toaster");
  EXPECT_EQ(realWords().category(of("wine glass").senses.front().synset), WordCategory::artifact);
  EXPECT_EQ(realWords().category(of("microwave").senses.front().synset), WordCategory::artifact);
  EXPECT_FALSE(of("refrigerator").isDoubtful);
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

}  // namespace
}  // namespace estancia
