// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/name_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "words/real_words.hpp"

namespace estancia {
namespace {

using testing::Contains;
using testing::IsEmpty;

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

}  // namespace
}  // namespace estancia
