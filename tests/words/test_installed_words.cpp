// Words that are installed, in dictionaries and in the lexicon: their meanings, spellings and names.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/dictionary.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/name_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <thread>

#include "estancia/core/home.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/words/label_choice.hpp"
#include "estancia/words/word_associations.hpp"
#include "estancia/words/word_files.hpp"
#include "estancia/words/word_graph.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using testing::IsEmpty;

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
      value.empty() ? unsetenv(variable) : setenv(variable, value.c_str(), 1);
  }
  static std::vector<fs::path> graphsIn(const fs::path& folder) {
    std::vector<fs::path> graphs;
    if (fs::exists(folder))
      for (const auto& entry : fs::directory_iterator(folder)) graphs.push_back(entry.path());
    return graphs;
  }

  const std::map<const char*, std::string> before_{{"ESTANCIA_WORDNET", environment("ESTANCIA_WORDNET")},
                                                   {"ESTANCIA_CACHE", environment("ESTANCIA_CACHE")}};
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
  EXPECT_THAT(loadInstalledWords().hint, testing::HasSubstr("index.verb, line 5"));
  const test::ScratchFolder empty;
  setenv("ESTANCIA_WORDNET", empty.path().c_str(), 1);
  EXPECT_FALSE(loadInstalledWords().graph);
  EXPECT_THAT(loadInstalledWords().hint, testing::HasSubstr(empty.path().string()));
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

const Lexicon& lexicon() {
  return test::realWords().lexicon;
}

bool meansOneOf(std::string_view word, std::string_view other, PartOfSpeech pos) {
  const std::vector<Sense> all = lexicon().senses(word), others = lexicon().senses(other);
  return std::any_of(others.begin(), others.end(), [&](const Sense& sense) {
    return test::realWords().pos(sense.synset) == pos &&
           std::any_of(all.begin(), all.end(), [&](const Sense& one) { return one.synset == sense.synset; });
  });
}

TEST(LexiconSenses, AreThoseOfTheSingularAndOfTheVerbThatIsInflected) {
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
  for (const auto& [form, verb] : {std::pair{"washing", "wash"},
                                   {"washes", "wash"},
                                   {"cooked", "cook"},
                                   {"stopped", "stop"},
                                   {"sitting", "sit"},
                                   {"slept", "sleep"},
                                   {"carries", "carry"},
                                   {"baking", "bake"}})
    EXPECT_TRUE(meansOneOf(form, verb, PartOfSpeech::verb)) << form;
  for (const char* word : {"", " ", "ing", "xyzzy", "ssss", "'s", "\x01", "\xff\xfe", "ящик", "the of"})
    EXPECT_THAT(lexicon().senses(word), IsEmpty()) << word;
  EXPECT_THAT(lexicon().senses(std::string(10000, 'a')), IsEmpty());
  EXPECT_THAT(Lexicon().senses("dog"), IsEmpty());
}

TEST(LexiconTerms, KeepWordsTogetherThatWordNetHasTogetherAndDropGrammar) {
  EXPECT_THAT(lexicon().terms("a living room with a coffee table"),
              ElementsAre("living room", "coffee table"));
  EXPECT_THAT(lexicon().terms("living-rooms"), ElementsAre("living rooms"));
  EXPECT_THAT(lexicon().terms("living_room"), ElementsAre("living room"));
  EXPECT_THAT(lexicon().terms("jack of all trades"), ElementsAre("jack of all trades"));
  EXPECT_THAT(lexicon().terms("a man of the world war"), ElementsAre("man of the world", "war"));
  EXPECT_THAT(lexicon().terms("kitchen knife"), ElementsAre("kitchen", "knife"));
  EXPECT_THAT(lexicon().terms("somewhere to sit"), ElementsAre("sit"));
  EXPECT_THAT(lexicon().terms("something I could use for washing"), ElementsAre("washing"));
  EXPECT_THAT(lexicon().terms("the of"), IsEmpty());
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

TEST(CorrectSpelling, FindsTheWordsOfASlipPreferringTheVocabulary) {
  for (const auto& [slip, word] : {std::pair{"refridgerator", "refrigerator"},
                                   {"kichen", "kitchen"},
                                   {"bycicle", "bicycle"},
                                   {"coffe", "coffee"},
                                   {"tabel", "table"},
                                   {"chiar", "chair"},
                                   {"calandar", "calendar"},
                                   {"somthing", "something"}})
    EXPECT_EQ(corrected(slip), word);
  EXPECT_EQ(corrected("livingroom"), "living room");
  EXPECT_EQ(corrected("coffeemug"), "coffee mug");
  EXPECT_EQ(corrected("sofs"), "soft");
  EXPECT_EQ(corrected("sofs", {"chair", "sofa"}), "sofa");
}

TEST(CorrectSpelling, GivesUpWhereNothingIsNearAndLeavesWhatIsNoPlainWord) {
  for (const char* garbage : {"", "a", "qq", "xyzzy", "qwrtpsdf", "zzzzzzzzzz", "aaaaaaaaaaaaaaaaaaaaaaaaaa"})
    EXPECT_EQ(corrected(garbage), "") << garbage;
  for (const std::size_t length : {40, 41, 10000}) EXPECT_EQ(corrected(std::string(length, 'x')), "");
  for (const char* other : {"chair1", "cha ir", "Chiar", "chi-ar", "ящик", "ch\xff", "caf\xc3\xa9", "it's"})
    EXPECT_EQ(corrected(other), "") << other;
}

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

TEST(NameSearch, CorrectsTheSpellingAndComparesMeaningsButTakesNothingUnsure) {
  EXPECT_EQ(meant("kichen"), "kitchen (by its spelling)");
  EXPECT_EQ(meant("bedrooom"), "bedroom (by its spelling)");
  EXPECT_EQ(meant("sitting room"), "living_room (the same as sitting room)");
  EXPECT_EQ(meant("cellar"), "basement (the same as cellar)");
  EXPECT_EQ(meant("bookshop"), "bookstore (the same as bookshop)");
  EXPECT_EQ(meant("kichen", nullptr), "?") << "without WordNet it may be a word";
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
  EXPECT_THAT(findNearNames(rooms(), "corridor", installedWordGraph), testing::Contains("hallway"));
  EXPECT_THAT(findNearNames(rooms(), "livingrom", nullptr), testing::Contains("living_room"));
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

TEST(LabelKinds, AreWhatTheWordNamesAndNotWhatIsOnlyRelated) {
  EXPECT_THAT(kindsOf("sofa"), ElementsAre("studio couch"));
  EXPECT_THAT(kindsOf("dogs"), ElementsAre("golden retriever", "beagle"));
  EXPECT_THAT(kindsOf("Dining_Table"), ElementsAre("dining table"));
  EXPECT_EQ(findLabelKinds(furnishings(), test::realWords(), "sofa")[0].reason, "a kind of sofa");
  EXPECT_EQ(findLabelKinds(furnishings(), test::realWords(), "espresso")[0].reason, "the same as espresso");
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
              testing::UnorderedElementsAre("golden retriever (a kind of dog)", "beagle (a kind of dog)"));
  EXPECT_THAT(described("dog", nullptr), IsEmpty());
  EXPECT_THAT(described("xyzzy", installedWordGraph), IsEmpty());
  const std::vector<LabelMatch> matches{{0, 1, "a"}, {1, 1, "b"}, {2, 1, "c"}};
  EXPECT_THAT(describeMatches(furnishings(), matches, 1), ElementsAre("studio couch (a)", "2 more"));
}

}  // namespace
}  // namespace estancia
