#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "estancia/core/vocabulary.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

TEST(Vocabulary, ReadsOneLabelALineAndDropsCarriageReturns) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt", "tench, Tinca tinca\r\ngoldfish  \r\n\r\n");
  const auto vocabulary = Vocabulary::fromFile(folder / "labels.txt");
  ASSERT_EQ(vocabulary.size(), 2U);
  EXPECT_EQ(vocabulary[0], "tench, Tinca tinca");
  EXPECT_EQ(vocabulary[1], "goldfish");
}

TEST(Vocabulary, KeepsLabelsThatStandTwiceAndDropsAByteOrderMark) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt",
                  "\xEF\xBB\xBF"
                  "crane\nheron\ncrane\n");
  EXPECT_EQ(Vocabulary::fromFile(folder / "labels.txt").labels(),
            (std::vector<std::string>{"crane", "heron", "crane"}));
}

TEST(Vocabulary, NamesTheLineOfAnEmptyLabel) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt", "cup\n\nmug\n");
  try {
    Vocabulary::fromFile(folder / "labels.txt");
    FAIL() << "an empty label must be refused";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("labels.txt:2"), std::string::npos) << e.what();
  }
}

TEST(Vocabulary, DigestDependsOnOrderAndOnBoundaries) {
  EXPECT_EQ(Vocabulary({"a", "b"}), Vocabulary({"a", "b"}));
  EXPECT_FALSE(Vocabulary({"a", "b"}) == Vocabulary({"b", "a"}));
  EXPECT_FALSE(Vocabulary({"ab", "c"}) == Vocabulary({"a", "bc"}));
}

TEST(Vocabulary, SaysWhereTwoDiffer) {
  try {
    requireSameVocabulary(Vocabulary({"cup", "mug"}), Vocabulary({"cup", "jug"}), "map.estancia");
    FAIL() << "different vocabularies must be refused";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("\"mug\" against \"jug\""), std::string::npos) << e.what();
  }
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
    EXPECT_NE(test::errorOf([&] { Vocabulary(labels, wrong); }), "");
}

}  // namespace
}  // namespace estancia
