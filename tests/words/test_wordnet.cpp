// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/wordnet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "support/errors.hpp"
#include "words/tiny_wordnet.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::ScratchFolder;
using test::tinyWordNet;
using test::WordNetTexts;
using testing::ElementsAre;

WordNet readTexts(const WordNetTexts& texts) {
  const ScratchFolder folder;
  test::writeWordNet(texts, folder.path());
  return readWordNet(folder.path());
}

/// The tiny WordNet, in one file of which `from` is replaced by `to`.
WordNetTexts with(const std::string& file, const std::string& from, const std::string& to) {
  WordNetTexts texts = tinyWordNet();
  std::string& text = texts.at(file);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  return texts;
}

const WordNetSynset& synsetOf(const WordNet& wordNet, PartOfSpeech pos, std::uint32_t offset) {
  for (const WordNetSynset& synset : wordNet.synsets)
    if (synset.pos == pos && synset.offset == offset) return synset;
  throw std::runtime_error("no such synset");
}

const WordNetEntry& entryOf(const WordNet& wordNet, PartOfSpeech pos, const std::string& word) {
  for (const WordNetEntry& entry : wordNet.entries)
    if (entry.pos == pos && entry.word == word) return entry;
  throw std::runtime_error("no such entry");
}

TEST(ReadWordNet, TellsWordsWithTheirCountsRelationsAndGlosses) {
  const WordNet wordNet = readTexts(tinyWordNet());
  ASSERT_EQ(wordNet.synsets.size(), 15U);
  const WordNetSynset& dog = synsetOf(wordNet, PartOfSpeech::noun, 300);
  EXPECT_THAT(dog.words, ElementsAre("dog", "domestic dog", "Canis familiaris"));
  EXPECT_THAT(dog.tagCounts, ElementsAre(42U, 0U, 0U));
  EXPECT_EQ(dog.category, WordCategory::animal);
  EXPECT_THAT(dog.gloss, testing::StartsWith("an animal that barks; \"the dog"));
  ASSERT_EQ(dog.relations.size(), 1U);
  EXPECT_EQ(dog.relations[0].symbol, "@");
  EXPECT_EQ(wordNet.synsets[dog.relations[0].target].offset, 200U);

  const WordNetSynset& cook = synsetOf(wordNet, PartOfSpeech::verb, 100);
  ASSERT_EQ(cook.relations.size(), 1U) << "verb frames follow; they are no relations";
  EXPECT_EQ(cook.relations[0].pos, PartOfSpeech::noun);
  EXPECT_EQ(wordNet.synsets[cook.relations[0].target].words.front(), "stove");
}

TEST(ReadWordNet, DropsWhereAnAdjectiveMayStandAndKnowsItsSatellites) {
  const WordNet wordNet = readTexts(tinyWordNet());
  const WordNetSynset& burning = synsetOf(wordNet, PartOfSpeech::adjective, 200);
  EXPECT_THAT(burning.words, ElementsAre("burning"));
  EXPECT_THAT(burning.tagCounts, ElementsAre(3U));
}

TEST(ReadWordNet, KnowsIrregularFormsOneOrSeveral) {
  const WordNet wordNet = readTexts(tinyWordNet());
  std::vector<std::string> told;
  for (const WordNet::IrregularForm& irregular : wordNet.irregularForms)
    told.push_back(irregular.form + " of " + irregular.word);
  EXPECT_THAT(told, ElementsAre("knives of knife", "mice of mouse", "cooken of cook", "cooken of wash"));
}

TEST(ReadWordNet, RefusesAMissingFile) {
  for (const auto& [name, text] : tinyWordNet()) {
    WordNetTexts texts = tinyWordNet();
    texts.erase(name);
    EXPECT_THAT([&] { readTexts(texts); }, FailsWith(ErrorCode::fileUnreadable));
  }
}

TEST(ReadWordNet, RefusesDamagedFiles) {
  struct Damage {
    const char *file, *from, *to;
  };
  for (const auto& [file, from, to] : std::vector<Damage>{
           {"data.noun", "00000200 05", "000x0200 05"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n"},
           {"data.noun", "00000300 05 n 03", "00000300 zz n 03"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n 00"},
           {"data.noun", "00000300 05 n 03", "00000300 05 q 03"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n ffffffff"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n fffffffff"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 4294967295 @ 00000200 n 0000 | an animal"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 -1 @ 00000200 n 0000 | an animal"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 001 @ 00000200 x 0000 | an animal"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 001 @ 00000201 n 0000 | an animal"},
           {"data.noun", "00000400 05 n 01 mouse", "00000300 05 n 01 mouse"},
           {"data.verb", "00000100 30 v", "00000100 30"},
           {"data.adv", "02 r 01 quickly 0 000", "02 r 01 quickly"},
           {"index.noun", "mouse n 2 1 @ 2 1 00000400 00000500", "mouse n 2 1 @ 2 1 00000400"},
           {"index.noun", "mouse n 2 1 @ 2 1 00000400", "mouse n 2 1 @ 2 1 00000401"},
           {"index.noun", "mouse n 2 1", "mouse n 4000000000 1"},
           {"index.noun", "mouse n 2 1", "mouse n 2 4000000000"},
           {"index.verb", "wash v 1", "wash v one"},
           {"noun.exc", "mice mouse", "mice"},
           {"cntlist.rev", "dog%1:05:00:: 1 42", "dog%1:05:00:: 1"},
           {"cntlist.rev", "dog%1:05:00:: 1 42", "dog%1:05:00:: 1 many"}})
    EXPECT_THAT([&] { readTexts(with(file, from, to)); }, FailsWith(ErrorCode::malformedFile)) << to;
}

TEST(FindWordNet, FollowsTheVariable) {
  const ScratchFolder folder;
  setenv("ESTANCIA_WORDNET", folder.path().c_str(), 1);
  EXPECT_EQ(findWordNet(), std::nullopt) << "an empty folder";
  test::writeWordNet(tinyWordNet(), folder.path());
  EXPECT_EQ(findWordNet(), folder.path());
  unsetenv("ESTANCIA_WORDNET");
}

TEST(InstalledWordNet, IsTheWholeOfVersionThree) {
  const std::optional<fs::path> folder = findWordNet();
  ASSERT_TRUE(folder) << "script/bootstrap installs wordnet-base";
  for (const fs::path& file : wordNetFiles(*folder)) EXPECT_TRUE(fs::is_regular_file(file)) << file;
  EXPECT_EQ(wordNetFiles(*folder).size(), 13U);
  const WordNet wordNet = readWordNet(*folder);
  EXPECT_EQ(wordNet.synsets.size(), 117659U);
  EXPECT_EQ(wordNet.entries.size(), 155287U);
  const WordNetSynset& dog = synsetOf(wordNet, PartOfSpeech::noun, 2084071);
  EXPECT_THAT(dog.words, ElementsAre("dog", "domestic dog", "Canis familiaris"));
  EXPECT_EQ(dog.tagCounts.front(), 42U);
  EXPECT_EQ(synsetOf(wordNet, PartOfSpeech::noun, 3063599).words.front(), "coffee mug");
  EXPECT_EQ(synsetOf(wordNet, PartOfSpeech::verb, 322847).pos, PartOfSpeech::verb);
  EXPECT_EQ(wordNet.synsets[entryOf(wordNet, PartOfSpeech::noun, "chair").synsets.front()].words.front(),
            "chair");
}

}  // namespace
}  // namespace estancia
