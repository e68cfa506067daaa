// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/wordnet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>

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

TEST(ReadWordNet, CountsWordsInHexadecimal) {
  const WordNet wordNet = readTexts(tinyWordNet());
  EXPECT_EQ(synsetOf(wordNet, PartOfSpeech::noun, 1000).words.size(), 10U);
}

TEST(ReadWordNet, TellsMeaningsOfOneWordApartByTheirLexicalNumber) {
  const WordNet wordNet = readTexts(tinyWordNet());
  EXPECT_EQ(synsetOf(wordNet, PartOfSpeech::noun, 400).tagCounts.front(), 5U);
  EXPECT_EQ(synsetOf(wordNet, PartOfSpeech::noun, 500).tagCounts.front(), 1U);
  const WordNetEntry& mouse = entryOf(wordNet, PartOfSpeech::noun, "mouse");
  ASSERT_EQ(mouse.synsets.size(), 2U);
  EXPECT_EQ(wordNet.synsets[mouse.synsets[0]].offset, 400U);
  EXPECT_EQ(wordNet.synsets[mouse.synsets[1]].offset, 500U);
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

TEST(ReadWordNet, TakesLinesThatEndAsOnWindows) {
  WordNetTexts texts = tinyWordNet();
  for (auto& [name, text] : texts) {
    std::string windows;
    for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    text = windows;
  }
  const WordNet wordNet = readTexts(texts), plain = readTexts(tinyWordNet());
  ASSERT_EQ(wordNet.synsets.size(), plain.synsets.size());
  for (std::size_t i = 0; i < plain.synsets.size(); ++i) {
    EXPECT_EQ(wordNet.synsets[i].gloss, plain.synsets[i].gloss);
    EXPECT_EQ(wordNet.synsets[i].words, plain.synsets[i].words);
  }
  EXPECT_EQ(wordNet.irregularForms.front().word, "knife");
}

TEST(ReadWordNet, NamesAMissingFile) {
  for (const auto& [name, text] : tinyWordNet()) {
    WordNetTexts texts = tinyWordNet();
    texts.erase(name);
    EXPECT_THAT([&] { readTexts(texts); }, FailsWith(ErrorCode::fileUnreadable, name, "wordnet-base"));
  }
}

TEST(ReadWordNet, NamesAFolderThatStandsForAFile) {
  for (const auto& [name, text] : tinyWordNet()) {
    const ScratchFolder folder;
    WordNetTexts texts = tinyWordNet();
    texts.erase(name);
    test::writeWordNet(texts, folder.path());
    fs::create_directory(folder / name);
    EXPECT_THAT([&] { readWordNet(folder.path()); },
                FailsWith(ErrorCode::fileUnreadable, name, "wordnet-base"));
  }
}

struct Damage {
  const char *file, *from, *to;
  /// Of the message.
  const char* place;
};

class DamagedWordNet : public testing::TestWithParam<Damage> {};

TEST_P(DamagedWordNet, IsRefusedWithFileAndLine) {
  const Damage& damage = GetParam();
  EXPECT_THAT([&] { readTexts(with(damage.file, damage.from, damage.to)); },
              FailsWith(ErrorCode::malformedFile, damage.file, damage.place, "wordnet-base"));
}

INSTANTIATE_TEST_SUITE_P(
    ReadWordNet, DamagedWordNet,
    testing::Values(
        Damage{"data.noun", "00000200 05", "000x0200 05", "line 3"},
        Damage{"data.noun", "00000300 05 n 03", "00000300 05 n", "line 4"},
        Damage{"data.noun", "00000300 05 n 03", "00000300 zz n 03", "line 4"},
        Damage{"data.noun", "00000300 05 n 03", "00000300 05 n 00", "line 4"},
        Damage{"data.noun", "00000300 05 n 03", "00000300 05 q 03", "line 4"},
        Damage{"data.noun", "00000300 05 n 03", "00000300 05 n ffffffff", "line 4"},
        Damage{"data.noun", "00000300 05 n 03", "00000300 05 n fffffffff", "line 4"},
        Damage{"data.noun", "0 001 @ 00000200 n 0000 | an animal",
               "0 4294967295 @ 00000200 n 0000 | an animal", "line 4"},
        Damage{"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 -1 @ 00000200 n 0000 | an animal",
               "line 4"},
        Damage{"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 001 @ 00000200 x 0000 | an animal",
               "line 4"},
        Damage{"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 001 @ 00000201 n 0000 | an animal",
               "line 4"},
        Damage{"data.noun", "00000400 05 n 01 mouse", "00000300 05 n 01 mouse", "line 5"},
        Damage{"data.verb", "00000100 30 v", "00000100 30", "line 2"},
        Damage{"data.adv", "02 r 01 quickly 0 000", "02 r 01 quickly", "line 2"},
        Damage{"index.noun", "mouse n 2 1 @ 2 1 00000400 00000500", "mouse n 2 1 @ 2 1 00000400", "line 13"},
        Damage{"index.noun", "mouse n 2 1 @ 2 1 00000400", "mouse n 2 1 @ 2 1 00000401", "line 13"},
        Damage{"index.noun", "mouse n 2 1", "mouse n 4000000000 1", "line 13"},
        Damage{"index.noun", "mouse n 2 1", "mouse n 2 4000000000", "line 13"},
        Damage{"index.verb", "wash v 1", "wash v one", "line 4"},
        Damage{"noun.exc", "mice mouse", "mice", "line 2"},
        Damage{"cntlist.rev", "dog%1:05:00:: 1 42", "dog%1:05:00:: 1", "line 3"},
        Damage{"cntlist.rev", "dog%1:05:00:: 1 42", "dog%1:05:00:: 1 many", "line 3"}));

TEST(ReadWordNet, RefusesFilesWithoutSynsetsOrWords) {
  for (const char* name : {"index.noun", "index.adv"}) {
    WordNetTexts texts = tinyWordNet();
    texts.at(name).clear();
    EXPECT_THAT([&] { readTexts(texts); }, FailsWith(ErrorCode::malformedFile, name, "wordnet-base"));
  }
  WordNetTexts empty = tinyWordNet();
  for (auto& [name, text] : empty) text.clear();
  EXPECT_THAT([&] { readTexts(empty); }, FailsWith(ErrorCode::malformedFile, "index.noun", "wordnet-base"));
}

TEST(ReadWordNet, RefusesBytesOfSomethingElse) {
  std::mt19937 random(7);
  for (const auto& [name, text] : tinyWordNet()) {
    WordNetTexts texts = tinyWordNet();
    std::string bytes(4096, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    bytes.front() = 'x';
    texts.at(name) = bytes;
    if (name.ends_with(".exc")) {
      try {
        readTexts(texts);
      } catch (const Error&) {  // a pair of odd words may also be taken
      }
    } else {
      EXPECT_THAT([&] { readTexts(texts); },
                  FailsWith(ErrorCode::malformedFile, name, "line", "wordnet-base"));
    }
  }
}

TEST(ReadWordNet, ReadsOrRefusesWhateverIsDamaged) {
  std::mt19937 random(19);
  const WordNetTexts sound = tinyWordNet();
  const ScratchFolder folder;
  test::writeWordNet(sound, folder.path());
  const std::string alphabet = "0123456789 \n|@~n_(%:x\xff";
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    const auto file = std::next(sound.begin(), static_cast<std::ptrdiff_t>(random() % sound.size()));
    std::string text = file->second;
    if (text.empty()) continue;
    if (round % 4 == 0)
      text.resize(random() % text.size());
    else
      for (unsigned edits = 1 + random() % 4; edits > 0 && !text.empty(); --edits) {
        const std::size_t at = random() % text.size();
        const char byte = alphabet[random() % alphabet.size()];
        if (random() % 3 == 0)
          text.erase(at, 1 + random() % 8);
        else if (random() % 2 == 0)
          text.insert(at, 1, byte);
        else
          text[at] = byte;
      }
    test::writeFile(folder / file->first, text);
    try {
      const WordNet wordNet = readWordNet(folder.path());
      for (const WordNetSynset& synset : wordNet.synsets) {
        ASSERT_EQ(synset.words.size(), synset.tagCounts.size());
        ASSERT_FALSE(synset.words.empty());
        for (const auto& relation : synset.relations) ASSERT_LT(relation.target, wordNet.synsets.size());
      }
      for (const WordNetEntry& entry : wordNet.entries)
        for (const std::uint32_t synset : entry.synsets) ASSERT_LT(synset, wordNet.synsets.size());
    } catch (const Error& error) {
      ++refused;
      ASSERT_THAT(error.what(),
                  testing::AllOf(testing::HasSubstr(", line "), testing::HasSubstr("wordnet-base")));
    }
    test::writeFile(folder / file->first, file->second);
  }
  EXPECT_GT(refused, 1000);
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
