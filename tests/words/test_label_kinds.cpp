// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_kinds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/label_words.hpp"
#include "estancia/words/label_choice.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

const Vocabulary& furnishings() {
  static const Vocabulary labels({"studio couch, day bed", "pillow", "golden retriever", "beagle",
                                  "refrigerator, icebox", "folding chair", "desk", "dining table",
                                  "espresso"});
  return labels;
}

std::vector<std::string> kindsOf(std::string_view words) {
  std::vector<std::string> labels;
  for (const LabelMatch& match : findLabelKinds(furnishings(), test::realWords(), words))
    labels.push_back(shortLabel(furnishings()[match.label]));
  return labels;
}

TEST(LabelKinds, AreWhatTheWordNames) {
  EXPECT_THAT(kindsOf("sofa"), ElementsAre("studio couch"));
  EXPECT_THAT(kindsOf("dogs"), ElementsAre("golden retriever", "beagle"));
  EXPECT_THAT(kindsOf("Dining_Table"), ElementsAre("dining table"));
  EXPECT_EQ(findLabelKinds(furnishings(), test::realWords(), "sofa")[0].reason, "a kind of sofa");
  EXPECT_EQ(findLabelKinds(furnishings(), test::realWords(), "espresso")[0].reason, "the same as espresso");
}

TEST(LabelKinds, WhatIsOnlyRelatedIsNone) {
  for (const char* words : {"cushion cover", "kitchen", "something to sit on", "sofaa", "xyzzy", "", "\xff"})
    EXPECT_THAT(kindsOf(words), IsEmpty()) << words;
}

TEST(LabelChoice, NamesGoFirstAndRelatedLabelsStandInForThem) {
  const auto described = [](std::string_view words, WordGraphSource source) {
    return describeMatches(furnishings(), chooseLabels(furnishings(), words, source).labels);
  };
  EXPECT_THAT(described("table", installedWordGraph), ElementsAre("dining table")) << "not the desk, too";
  EXPECT_THAT(described("couch", nullptr), ElementsAre("studio couch")) << "its name holds the word";
  EXPECT_THAT(described("dog", installedWordGraph),
              UnorderedElementsAre("golden retriever (a kind of dog)", "beagle (a kind of dog)"));
  EXPECT_THAT(described("dog", nullptr), IsEmpty());
  EXPECT_THAT(described("xyzzy", installedWordGraph), IsEmpty());
}

TEST(LabelChoice, LongListsEndWithTheNumberOfTheOthers) {
  const std::vector<LabelMatch> matches{{0, 1, "a"}, {1, 1, "b"}, {2, 1, "c"}};
  EXPECT_THAT(describeMatches(furnishings(), matches, 1), ElementsAre("studio couch (a)", "2 more"));
}

}  // namespace
}  // namespace estancia
