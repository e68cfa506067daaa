// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_search.hpp"
#include "estancia/words/name_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/label_words.hpp"
#include "estancia/words/label_choice.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

/// Rooms as data sets write them.
const std::vector<std::string>& rooms() {
  static const std::vector<std::string> names{
      "basement", "bathroom",    "bedroom",        "bookstore", "computer_lab", "dining_room",     "foyer",
      "hallway",  "living_room", "office_kitchen", "office",    "kitchen",      "2-person office", "Café"};
  return names;
}

/// "NAME (REASON)", or "?".
std::string meant(std::string_view words, WordGraphSource source = installedWordGraph) {
  const auto match = findName(rooms(), words, source);
  if (!match) return "?";
  return rooms()[match->name] + (match->reason.empty() ? "" : " (" + match->reason + ")");
}

TEST(NameSearch, CasePluralsHyphensAndBlanksDoNotMatter) {
  for (const WordGraphSource source : {WordGraphSource{nullptr}, WordGraphSource{installedWordGraph}}) {
    EXPECT_EQ(meant("living_room", source), "living_room");
    EXPECT_EQ(meant("Living Rooms", source), "living_room");
    EXPECT_EQ(meant("livingroom", source), "living_room");
    EXPECT_EQ(meant("BED-ROOM", source), "bedroom");
    EXPECT_EQ(meant("kitchens", source), "kitchen") << "not the office kitchen";
    EXPECT_EQ(meant("2 person office", source), "2-person office");
    EXPECT_EQ(meant("CAF\u00c9", source), "Café");
  }
}

TEST(NameSearch, SpellingIsCorrectedAndMeaningsAreCompared) {
  EXPECT_EQ(meant("kichen"), "kitchen (by its spelling)");
  EXPECT_EQ(meant("bedrooom"), "bedroom (by its spelling)");
  EXPECT_EQ(meant("sitting room"), "living_room (the same as sitting room)");
  EXPECT_EQ(meant("cellar"), "basement (the same as cellar)");
  EXPECT_EQ(meant("bookshop"), "bookstore (the same as bookshop)");
  EXPECT_EQ(meant("kichen", nullptr), "?") << "without WordNet it may be a word";
}

TEST(NameSearch, WhatIsUnsureIsNotTaken) {
  for (const char* words : {"garage", "corridor", "nursery", "room", "3-person office", "toilet", "xyzzy", "",
                            "  ", "\x01\xff", "lab"})
    EXPECT_EQ(meant(words), "?") << words;
  EXPECT_EQ(meant(std::string(100000, 'k')), "?");
  const std::vector<std::string> alike{"bed room", "bedrooms", "hall"};
  EXPECT_FALSE(findName(alike, "bedroom", installedWordGraph)) << "it may be either";
  EXPECT_EQ(findName(alike, "bedrooms", installedWordGraph)->name, 1U);
}

TEST(NameSearch, AKindOfANameStandsForIt) {
  const auto kind = [](std::string_view words, WordGraphSource source = installedWordGraph) {
    const auto match = findNameOfKind({"corridor", "bedroom", "kitchen"}, words, source);
    return match ? static_cast<int>(match->name) : -1;
  };
  EXPECT_EQ(kind("hallway"), 0);
  EXPECT_EQ(kind("the guestroom"), 1);
  EXPECT_EQ(kind("kitchenette"), 2);
  for (const char* words : {"corridor", "room", "building", "chair", "xyzzy", "", "\x01"})
    EXPECT_EQ(kind(words), -1) << words;
  EXPECT_EQ(kind("hallway", nullptr), -1);
  EXPECT_FALSE(findNameOfKind({"bedroom", "sleeping room"}, "guestroom", installedWordGraph)) << "either";
}

TEST(NameSearch, NearNamesAreSuggested) {
  EXPECT_THAT(findNearNames(rooms(), "corridor", installedWordGraph), Contains("hallway"));
  EXPECT_THAT(findNearNames(rooms(), "livingrom", nullptr), Contains("living_room"));
  EXPECT_THAT(findNearNames(rooms(), "xyzzy", installedWordGraph), IsEmpty());
  EXPECT_THAT(findNearNames(rooms(), "", installedWordGraph), IsEmpty());
  EXPECT_THAT(findNearNames({}, "hall", installedWordGraph), IsEmpty());
  EXPECT_THAT(findNearNames(rooms(), "room", installedWordGraph), testing::SizeIs(testing::Le(3)));
}

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
