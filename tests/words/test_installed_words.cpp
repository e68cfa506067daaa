// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/dictionary.hpp"
#include "estancia/words/installed_words.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <thread>

#include "estancia/words/word_associations.hpp"
#include "estancia/words/word_files.hpp"
#include "estancia/words/word_graph.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "words/tiny_wordnet.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::writeFile;
using testing::HasSubstr;

/// A tiny WordNet as the installed one, and an empty folder for the cache.
class InstalledWordsTest : public testing::Test {
 protected:
  InstalledWordsTest() {
    test::writeWordNet(test::tinyWordNet(), wordNet_.path());
    setenv("ESTANCIA_WORDNET", wordNet_.path().c_str(), 1);
    setenv("ESTANCIA_CACHE", (cache_ / "own").c_str(), 1);
  }
  ~InstalledWordsTest() override {
    for (const auto& [variable, value] : before_)
      if (value)
        setenv(variable.c_str(), value->c_str(), 1);
      else
        unsetenv(variable.c_str());
  }
  static std::vector<fs::path> graphsIn(const fs::path& folder) {
    std::vector<fs::path> graphs;
    if (fs::exists(folder))
      for (const auto& entry : fs::directory_iterator(folder)) graphs.push_back(entry.path());
    return graphs;
  }

  const std::map<std::string, std::optional<std::string>> before_ = [] {
    std::map<std::string, std::optional<std::string>> values;
    for (const char* variable : {"ESTANCIA_WORDNET", "ESTANCIA_CACHE", "XDG_CACHE_HOME"})
      if (const char* value = std::getenv(variable))
        values[variable] = value;
      else
        values[variable] = std::nullopt;
    return values;
  }();
  test::ScratchFolder wordNet_, cache_;
};

TEST_F(InstalledWordsTest, AreKeptInTheCache) {
  const InstalledWords words = loadInstalledWords();
  ASSERT_TRUE(words.graph);
  EXPECT_EQ(words.hint, "");
  EXPECT_EQ(words.graph->size(), 15U);
  const std::vector<fs::path> graphs = graphsIn(cache_ / "own");
  ASSERT_EQ(graphs.size(), 1U);
  EXPECT_THAT(graphs.front().filename().string(), testing::MatchesRegex("words-[0-9a-f]{8}\\.graph"));
  const auto written = fs::last_write_time(graphs.front());
  EXPECT_EQ(loadInstalledWords().graph->edgeTargets, words.graph->edgeTargets);
  EXPECT_EQ(fs::last_write_time(graphs.front()), written) << "it was read";
}

TEST_F(InstalledWordsTest, ReplaceADamagedCache) {
  loadInstalledWords();
  const fs::path cached = graphsIn(cache_ / "own").at(0);
  const std::string sound = test::readFile(cached);
  std::string changed = sound;
  changed[changed.size() / 2] = '\xff';
  changed[changed.size() / 2 + 1] = '\xff';
  for (const std::string& damage : {std::string(), sound.substr(0, 100), std::string("text"), changed}) {
    test::writeFile(cached, damage);
    const InstalledWords words = loadInstalledWords();
    ASSERT_TRUE(words.graph) << words.hint;
    EXPECT_EQ(words.graph->size(), 15U);
    if (damage != changed) {  // the damage may give another valid one
      EXPECT_EQ(test::readFile(cached), sound);
    }
  }
}

TEST_F(InstalledWordsTest, DoNotMindACacheThatCannotBeWritten) {
  test::writeFile(cache_ / "file", "");
  setenv("ESTANCIA_CACHE", (cache_ / "file" / "folder").c_str(), 1);
  const InstalledWords words = loadInstalledWords();
  EXPECT_TRUE(words.graph);
  EXPECT_EQ(words.hint, "");
}

TEST_F(InstalledWordsTest, AreMadeAnewForAnotherWordNet) {
  loadInstalledWords();
  test::WordNetTexts texts = test::tinyWordNet();
  texts.at("noun.exc") += "feet entity\n";
  test::writeWordNet(texts, wordNet_.path());
  EXPECT_TRUE(loadInstalledWords().graph->lexicon.knows("feet"));
}

TEST_F(InstalledWordsTest, AreNoneWithoutASoundWordNetAndTheHintTellsWhatToDo) {
  test::WordNetTexts texts = test::tinyWordNet();
  texts.at("index.verb") += "broken\n";
  test::writeWordNet(texts, wordNet_.path());
  EXPECT_FALSE(loadInstalledWords().graph);
  EXPECT_THAT(loadInstalledWords().hint, HasSubstr("index.verb, line 5"));
  const test::ScratchFolder empty;
  setenv("ESTANCIA_WORDNET", empty.path().c_str(), 1);
  EXPECT_FALSE(loadInstalledWords().graph);
  EXPECT_THAT(loadInstalledWords().hint, HasSubstr(empty.path().string()));
  EXPECT_TRUE(graphsIn(cache_ / "own").empty());
  EXPECT_TRUE(installedAssociations(Vocabulary({"dog"}))->empty());
}

TEST(InstalledWordGraph, IsReadOnceForAllThreads) {
  std::vector<const WordGraph*> graphs(4);
  {
    std::vector<std::jthread> threads;
    for (const WordGraph*& graph : graphs) threads.emplace_back([&graph] { graph = installedWordGraph(); });
  }
  EXPECT_THAT(graphs, testing::Each(graphs.front()));
  EXPECT_NE(graphs.front(), nullptr);
  EXPECT_EQ(wordNetHint(), "");
}

TEST_F(InstalledWordsTest, AssociationsAreKeptForEachListOfLabels) {
  const fs::path folder = cache_ / "own";
  const Vocabulary animals({"dog", "mouse"}), rooms({"kitchen", "living room"});
  const auto filesOfAssociations = [&] {
    std::vector<fs::path> files = graphsIn(folder);
    std::erase_if(files, [](const fs::path& file) { return file.extension() != ".words"; });
    return files;
  };
  const std::vector<WordAssociation> first = *installedAssociations(animals);
  ASSERT_FALSE(first.empty());
  ASSERT_EQ(filesOfAssociations().size(), 1U);
  EXPECT_EQ(*installedAssociations(animals), first);
  EXPECT_NE(*installedAssociations(rooms), first);
  EXPECT_EQ(filesOfAssociations().size(), 2U);
  for (const fs::path& file : filesOfAssociations()) fs::resize_file(file, 30);
  EXPECT_EQ(*installedAssociations(animals), first) << "made anew";
}

class Dictionaries : public testing::Test {
 protected:
  Dictionary of(const std::string& text) {
    writeFile(file_, text);
    return Dictionary(file_);
  }

  test::ScratchFolder scratch_;
  const std::filesystem::path file_ = scratch_ / "german.txt";
};

TEST_F(Dictionaries, TranslateWholeTextsThenWords) {
  const Dictionary german =
      of("# German\nK\xC3\xBC"
         "che\tkitchen\r\n\nstuhl,chair\nrotes Sofa\tred couch\nrot\tred\nstuhl\tstool\n");
  EXPECT_EQ(german.translate("K\xC3\xBC"
                             "che"),
            "kitchen");
  EXPECT_EQ(german.translate("K\xC3\x9C"
                             "CHE"),
            "kitchen")
      << "capitals of Latin-1";
  EXPECT_EQ(german.translate("  Stuhl "), "chair") << "the first of two lines";
  EXPECT_EQ(german.translate("rotes sofa"), "red couch");
  EXPECT_EQ(german.translate("rot Stuhl blau"), "red chair blau");
  EXPECT_EQ(german.translate(""), "");
}

TEST_F(Dictionaries, MayBeginWithAByteOrderMark) {
  EXPECT_EQ(of("\xEF\xBB\xBFstuhl\tchair\n").translate("Stuhl"), "chair");
}

TEST_F(Dictionaries, RefuseOtherFiles) {
  for (const std::string& text :
       {std::string("stuhl\tchair\nsofa\n"), std::string("stuhl\t\n"), std::string("\tchair\n"),
        std::string("K\xFC\tkitchen\n"), std::string("\xFF\xFEs\0t\0", 6)})
    EXPECT_THAT([&] { of(text); }, FailsWith(ErrorCode::malformedFile)) << text;
  EXPECT_THAT([&] { of("# nothing yet\n\n"); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { Dictionary(scratch_ / "none.txt"); }, FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT([&] { Dictionary{scratch_.path()}; }, FailsWith(ErrorCode::fileUnreadable));
}

}  // namespace
}  // namespace estancia
