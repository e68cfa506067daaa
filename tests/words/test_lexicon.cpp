// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/lexicon.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "words/real_words.hpp"

namespace estancia {
namespace {

using test::realWords;
using testing::ElementsAre;
using testing::IsEmpty;

const Lexicon& lexicon() {
  return realWords().lexicon;
}

bool meansOneOf(std::string_view word, std::string_view other, PartOfSpeech pos) {
  const std::vector<Sense> all = lexicon().senses(word), others = lexicon().senses(other);
  return std::any_of(others.begin(), others.end(), [&](const Sense& sense) {
    return realWords().pos(sense.synset) == pos &&
           std::any_of(all.begin(), all.end(), [&](const Sense& one) { return one.synset == sense.synset; });
  });
}

TEST(LexiconSenses, AreThoseOfTheSingularToo) {
  for (const auto& [many, one] : {std::pair{"chairs", "chair"},
                                  {"buses", "bus"},
                                  {"benches", "bench"},
                                  {"batteries", "battery"},
                                  {"mice", "mouse"},
                                  {"knives", "knife"},
                                  {"firemen", "fireman"},
                                  {"coffee mugs", "coffee mug"},
                                  {"cookies", "cookie"}})
    EXPECT_TRUE(meansOneOf(many, one, PartOfSpeech::noun)) << many;
  EXPECT_FALSE(meansOneOf("cookies", "cook", PartOfSpeech::noun));
}

TEST(LexiconSenses, AreThoseOfTheVerbThatIsInflected) {
  for (const auto& [form, verb] : {std::pair{"washing", "wash"},
                                   {"washes", "wash"},
                                   {"cooked", "cook"},
                                   {"stopped", "stop"},
                                   {"sitting", "sit"},
                                   {"slept", "sleep"},
                                   {"carries", "carry"},
                                   {"baking", "bake"}})
    EXPECT_TRUE(meansOneOf(form, verb, PartOfSpeech::verb)) << form;
}

TEST(LexiconSenses, AreNoneForUnknownWords) {
  for (const char* word : {"", " ", "ing", "xyzzy", "ssss", "'s", "\x01", "\xff\xfe", "ящик", "the of"})
    EXPECT_THAT(lexicon().senses(word), IsEmpty()) << word;
  EXPECT_THAT(lexicon().senses(std::string(10000, 'a')), IsEmpty());
  EXPECT_THAT(Lexicon().senses("dog"), IsEmpty());
}

TEST(LexiconTerms, KeepWordsTogetherThatWordNetHasTogether) {
  EXPECT_THAT(lexicon().terms("a living room with a coffee table"),
              ElementsAre("living room", "coffee table"));
  EXPECT_THAT(lexicon().terms("living-rooms"), ElementsAre("living rooms"));
  EXPECT_THAT(lexicon().terms("living_room"), ElementsAre("living room"));
  EXPECT_THAT(lexicon().terms("jack of all trades"), ElementsAre("jack of all trades"));
  EXPECT_THAT(lexicon().terms("a man of the world war"), ElementsAre("man of the world", "war"));
  EXPECT_THAT(lexicon().terms("kitchen knife"), ElementsAre("kitchen", "knife"));
}

TEST(LexiconTerms, DropWordsThatOnlyServeGrammar) {
  EXPECT_THAT(lexicon().terms("somewhere to sit"), ElementsAre("sit"));
  EXPECT_THAT(lexicon().terms("something I could use for washing"), ElementsAre("washing"));
  EXPECT_THAT(lexicon().terms("the of"), IsEmpty());
}

TEST(LexiconTerms, AreTakenFromAnyBytes) {
  EXPECT_THAT(lexicon().terms(""), IsEmpty());
  EXPECT_THAT(lexicon().terms(" \t\n.,;!?-_'\x01\x7f"), IsEmpty());
  EXPECT_THAT(lexicon().terms("the dog's bed"), ElementsAre("dog's", "bed"));
  EXPECT_THAT(lexicon().terms("the dog\u2019s bed"), ElementsAre("dog's", "bed")) << "as phones write it";
  EXPECT_THAT(lexicon().terms("'dogs' \u2018dogs\u2019"), ElementsAre("dogs", "dogs"));
  EXPECT_THAT(lexicon().terms("chair\x01table"), ElementsAre("chair", "table"));
  EXPECT_THAT(lexicon().terms("ящик"), ElementsAre("ящик"));
  EXPECT_THAT(lexicon().terms("\xff\xfe\xe2\x80"), testing::SizeIs(testing::Le(1U)));
  EXPECT_THAT(lexicon().terms(std::string("chair\0table", 11)), ElementsAre("chair", "table"));
}

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
