// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estancia/core/vocabulary.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

TEST(Vocabulary, ReadsOneLabelALineAndDropsCarriageReturns) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt", "tench, Tinca tinca\r\ngoldfish  \r\n\r\n");
  const auto vocabulary = readVocabulary(folder / "labels.txt");
  ASSERT_EQ(vocabulary.size(), 2U);
  EXPECT_EQ(vocabulary[0], "tench, Tinca tinca");
  EXPECT_EQ(vocabulary[1], "goldfish");
}

TEST(Vocabulary, KeepsLabelsThatStandTwiceAndDropsAByteOrderMark) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt",
                  "\xEF\xBB\xBF"
                  "crane\nheron\ncrane\n");
  EXPECT_EQ(readVocabulary(folder / "labels.txt").labels(),
            (std::vector<std::string>{"crane", "heron", "crane"}));
}

TEST(Vocabulary, LabelsOfAFileHoldNoControlCharacters) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt", "n01440764\ttench\nred\x1B[2J\ncaf\xE9\n");
  EXPECT_EQ(readVocabulary(folder / "labels.txt").labels(),
            (std::vector<std::string>{"n01440764 tench", "red\\x1B[2J", "caf\\xE9"}));
}

TEST(Vocabulary, NamesTheLineOfAnEmptyLabel) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "labels.txt", "cup\n\nmug\n");
  EXPECT_THAT([&] { readVocabulary(folder / "labels.txt"); },
              FailsWith(ErrorCode::malformedFile, "labels.txt:2"));
  test::writeFile(folder / "labels.txt", "\r\n");
  EXPECT_THAT([&] { readVocabulary(folder / "labels.txt"); },
              FailsWith(ErrorCode::malformedFile, "labels.txt"));
  EXPECT_THAT([&] { readVocabulary(folder / "none.txt"); }, FailsWith(ErrorCode::fileUnreadable, "none.txt"));
}

TEST(Vocabulary, DigestDependsOnOrderAndOnBoundaries) {
  EXPECT_EQ(Vocabulary({"a", "b"}), Vocabulary({"a", "b"}));
  EXPECT_FALSE(Vocabulary({"a", "b"}) == Vocabulary({"b", "a"}));
  EXPECT_FALSE(Vocabulary({"ab", "c"}) == Vocabulary({"a", "bc"}));
}

TEST(Vocabulary, SaysWhereTwoDiffer) {
  const Vocabulary mug({"cup", "mug"}), jug({"cup", "jug"});
  EXPECT_THAT([&] { requireSameVocabulary(mug, jug, "map.estancia"); },
              FailsWith(ErrorCode::mismatch, "map.estancia", "\"mug\"", "\"jug\""));
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
    EXPECT_THAT([&] { Vocabulary(labels, wrong); }, FailsWith(ErrorCode::invalidInput, "3"));
}

}  // namespace
}  // namespace estancia
