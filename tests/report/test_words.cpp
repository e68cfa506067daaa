// What the search box of a page understands, and that its script finds what ask finds.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "estancia/core/label_words.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/page_words.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/word_associations.hpp"
#include "support/html_checks.hpp"
#include "support/report_map.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::count;
using test::expectNothingFromOutside;
using test::expectWellFormed;
using test::realWords;
using testing::Contains;
using testing::IsEmpty;

TopologicalMap mapOf(std::vector<std::string> labels, std::size_t used) {
  TopologicalMap map = test::sampleMap({.labels = labels.size()});
  map.vocabulary = Vocabulary(std::move(labels));
  for (Node& node : map.nodes)
    for (std::size_t label = 0; label < node.mean.size(); ++label)
      node.mean[label] = label < used ? 1.0F / static_cast<float>(used) : 0;
  return map;
}

/// Twenty labels, of which a place shows the first ten.
std::vector<std::string> twentyLabels() {
  std::vector<std::string> labels;
  for (char c = 'a'; c < 'a' + 20; ++c) labels.push_back(std::string("thing ") + c + c);
  return labels;
}

TEST(PageWords, HoldTheWordsOfLabelsThatTheMapShows) {
  const TopologicalMap map = mapOf(twentyLabels(), 10);
  const std::vector<WordAssociation> words{{"bed", true, {{12, 95}, {3, 90}, {4, 35}}},
                                           {"cot", false, {{12, 94}, {13, 93}}},
                                           {"rarely", false, {{13, 93}}},
                                           {"truth", true, {}}};
  MapPage page{map};
  page.words = &words;
  const nlohmann::json data = report::pageWords(page);
  EXPECT_EQ(data["labels"], nlohmann::json({3, 4}));
  EXPECT_EQ(data["text"], "0bed002I010Z0truth") << "known words stay, so that none is taken for misspelled";
  const std::vector<WordAssociation> named{{"mm", true, {{12, 95}}}, {"nn", true, {{12, 95}}}};
  page.words = &named;
  EXPECT_EQ(report::pageWords(page)["labels"], nlohmann::json({12})) << "a label that the word names";
}

TEST(PageWords, AreLeftOutWithoutWordNet) {
  const TopologicalMap map = mapOf(twentyLabels(), 10);
  const std::vector<WordAssociation> none;
  MapPage page{map};
  EXPECT_TRUE(report::pageWords(page).is_null());
  const std::string before = renderMapPage(page);
  page.words = &none;
  EXPECT_EQ(renderMapPage(page), before);
  EXPECT_EQ(count(before, "\"grammar\""), 0U);
}

TEST(PageWords, LeaveRareWordsOutWhereTheyAreTooMany) {
  const TopologicalMap map = mapOf(twentyLabels(), 10);
  std::vector<WordAssociation> words;
  for (char a = 'a'; a <= 'z'; ++a)
    for (char b = 'a'; b <= 'z'; ++b) {
      std::string word = "qa";
      word[0] = a;
      word[1] = b;
      words.push_back({word, a == 'x', {{1, static_cast<std::uint8_t>(a < 'm' ? 65 : 95)}}});
    }
  MapPage page{map};
  page.words = &words;
  const auto bytes = [&page](std::size_t most) {
    page.wordBytes = most;
    return report::pageWords(page)["text"].get<std::string>().size();
  };
  const std::size_t all = bytes(100'000), likely = bytes(all - 1), frequent = bytes(likely - 1);
  EXPECT_LT(likely, all);
  EXPECT_LT(frequent, likely);
  EXPECT_EQ(bytes(1), frequent) << "frequent words stay";
}

TEST(PageWords, HostileLabelsCannotBreakOut) {
  std::vector<std::string> labels = twentyLabels();
  labels[0] = "</script><script>alert(1)</script>";
  labels[1] = "quotes \" ' ` and <!--";
  labels[2] = std::string("control \x01\x02 and \xFF bytes");
  const TopologicalMap map = mapOf(labels, 10);
  const std::vector<WordAssociation> words{{"alert", true, {{0, 90}, {1, 80}, {2, 70}}}};
  MapPage page{map};
  page.words = &words;
  const std::string html = renderMapPage(page);
  expectWellFormed(html);
  expectNothingFromOutside(html);
  EXPECT_EQ(count(html, "<script"), 2U) << "data and ours";
  EXPECT_EQ(count(html, "0alert002I0128021Y"), 1U);
  EXPECT_EQ(renderMapPage(page), html);
}

class WordSearchScript : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const auto every = [](const std::string&, std::uint32_t) { return true; };
    const PackedAssociations packed =
        packAssociations(selectAssociations(associateWords(realWords(), labels()), every));
    const nlohmann::json data{{"words",
                               {{"labels", packed.labels},
                                {"text", packed.text},
                                {"known", packWordFilter(knownWords())},
                                {"grammar", fmt::format("{}", fmt::join(functionWords(), " "))}}}};
    folder() = std::make_unique<test::ScratchFolder>();
    test::writeFile(*folder() / "page.json", data.dump());
    test::writeFile(*folder() / "ask.js", R"(
      const fs = require('fs'), [, , script, page, words] = process.argv;
      const document = {getElementById: () => ({textContent: fs.readFileSync(page, 'utf8')})};
      const search = new Function('document', fs.readFileSync(script, 'utf8') + '; return wordSearch;')(document);
      console.log(JSON.stringify(JSON.parse(fs.readFileSync(words, 'utf8')).map(search.understand)));
    )");
  }
  static void TearDownTestSuite() { folder().reset(); }

  static const Vocabulary& labels() {
    static const Vocabulary all({"coffee mug", "espresso maker", "studio couch, day bed", "folding chair",
                                 "desk", "minivan", "golden retriever", "stove", "refrigerator, icebox",
                                 "microwave, microwave oven", "bookcase", "toilet seat", "table lamp",
                                 "dishwasher", "vacuum, vacuum cleaner", "bathtub", "four-poster"});
    return all;
  }

  /// One word each, as a page knows them beside those that it lists.
  static std::vector<std::string_view> knownWords() {
    const Lexicon& lexicon = realWords().lexicon;
    std::vector<std::string_view> words;
    for (std::size_t i = 0; i < lexicon.size(); ++i)
      if (isTypedWord(lexicon.word(i)) && lexicon.word(i).find(' ') == std::string_view::npos)
        words.push_back(lexicon.word(i));
    return words;
  }

  /// What the script understands by each text: {labels: [[label, probability], …], corrected, known}.
  static nlohmann::json understand(const std::vector<std::string>& texts) {
    test::writeFile(*folder() / "texts.json", nlohmann::json(texts).dump());
    const auto run = test::runProgram(
        "node", {*folder() / "ask.js", fs::path(ESTANCIA_SOURCE_DIR) / "estancia/report/word_search.js",
                 *folder() / "page.json", *folder() / "texts.json"});
    if (run.exitCode != 0) throw std::runtime_error("node failed (is it installed?): " + run.err);
    return nlohmann::json::parse(run.out);
  }

  static std::vector<std::string> namesIn(const nlohmann::json& understood) {
    std::vector<std::string> names;
    for (const auto& label : understood["labels"]) names.push_back(shortLabel(labels()[label[0]]));
    return names;
  }

 private:
  static std::unique_ptr<test::ScratchFolder>& folder() {
    static std::unique_ptr<test::ScratchFolder> all;
    return all;
  }
};

/// One test, since the words are packed anew in each process.
TEST_F(WordSearchScript, FindsWhatLabelSearchFindsAndCorrectsAsItDoes) {
  const LabelSearch search(labels(), &realWords());
  const std::vector<std::string> texts{"coffee", "kitchen",  "living room", "sit",    "sleep", "vehicle",
                                       "couch",  "beverage", "dog",         "fridge", "cook",  "Furniture"};
  const nlohmann::json found = understand(texts);
  for (std::size_t t = 0; t < texts.size(); ++t) {
    const std::vector<double> expected = search.likely(texts[t]);
    std::set<std::size_t> likely;
    for (const auto& label : found[t]["labels"]) {
      likely.insert(label[0].get<std::size_t>());
      EXPECT_NEAR(label[1].get<double>(), expected[label[0].get<std::size_t>()], 0.0051) << texts[t];
    }
    for (std::size_t label = 0; label < expected.size(); ++label)
      EXPECT_EQ(likely.contains(label), expected[label] > 0) << texts[t] << ": " << labels()[label];
  }

  // Forms, spellings and several words; a word that is known elsewhere is not corrected.
  const nlohmann::json understood = understand({"sofas", "refridgerator", "wash the dishes", "the Coffee's",
                                                "nippies", "curtian", "book case", "t v"});
  EXPECT_THAT(namesIn(understood[0]), Contains("studio couch"));
  EXPECT_EQ(understood[0]["corrected"], "");
  EXPECT_THAT(namesIn(understood[1]), Contains("refrigerator"));
  EXPECT_EQ(understood[1]["corrected"], "refrigerator");
  EXPECT_EQ(namesIn(understood[2]).at(0), "dishwasher");
  EXPECT_THAT(namesIn(understood[3]), Contains("espresso maker"));
  EXPECT_THAT(namesIn(understood[4]), IsEmpty()) << "known and not a thing here";
  EXPECT_EQ(understood[4]["known"], true);
  EXPECT_EQ(understood[4]["corrected"], "");
  EXPECT_EQ(understood[5]["corrected"], "curtain");
  EXPECT_EQ(namesIn(understood[6]).at(0), "bookcase") << "written apart";
  EXPECT_THAT(namesIn(understood[7]), IsEmpty()) << "letters";

  const std::string script = "</script><script>alert(1)", letters(100'000, 'x');
  for (const nlohmann::json& one : understand({"", "xyzzyq", "of the", "кухня", "\x01\x02", letters, script}))
    EXPECT_THAT(namesIn(one), IsEmpty()) << one.dump().substr(0, 99);
}

}  // namespace
}  // namespace estancia
