// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "estancia/core/vocabulary.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

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

}  // namespace
}  // namespace estancia
