// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/spelling.hpp"

#include <gtest/gtest.h>

#include "words/real_words.hpp"

namespace estancia {
namespace {

std::string corrected(std::string_view word, const std::vector<std::string>& preferred = {}) {
  return correctSpelling(test::realWords().lexicon, preferred, word);
}

TEST(CorrectSpelling, FindsTheWordOfASlip) {
  for (const auto& [slip, word] : {std::pair{"refridgerator", "refrigerator"},
                                   {"kichen", "kitchen"},
                                   {"bycicle", "bicycle"},
                                   {"coffe", "coffee"},
                                   {"tabel", "table"},
                                   {"chiar", "chair"},
                                   {"calandar", "calendar"},
                                   {"somthing", "something"}})
    EXPECT_EQ(corrected(slip), word);
}

TEST(CorrectSpelling, DividesWhatIsTwoWords) {
  EXPECT_EQ(corrected("livingroom"), "living room");
  EXPECT_EQ(corrected("coffeemug"), "coffee mug");
}

TEST(CorrectSpelling, PrefersWordsOfTheVocabulary) {
  EXPECT_EQ(corrected("sofs"), "soft");
  EXPECT_EQ(corrected("sofs", {"chair", "sofa"}), "sofa");
}

TEST(CorrectSpelling, GivesUpWhereNothingIsNear) {
  for (const char* garbage : {"", "a", "qq", "xyzzy", "qwrtpsdf", "zzzzzzzzzz", "aaaaaaaaaaaaaaaaaaaaaaaaaa"})
    EXPECT_EQ(corrected(garbage), "") << garbage;
  EXPECT_EQ(corrected(std::string(40, 'x')), "");
  EXPECT_EQ(corrected(std::string(41, 'x')), "");
  EXPECT_EQ(corrected(std::string(10000, 'c')), "");
}

TEST(CorrectSpelling, LeavesWhatIsNoPlainWord) {
  for (const char* other : {"chair1", "cha ir", "Chiar", "chi-ar", "ящик",
                            "ch\xff"
                            "ar",
                            "caf\xc3\xa9", "it's"})
    EXPECT_EQ(corrected(other), "") << other;
}

}  // namespace
}  // namespace estancia
