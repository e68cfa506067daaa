// The script that searches a page by words finds what `ask` finds; run by node, which npm needs anyway.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "estancia/core/label_words.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/word_associations.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::realWords;
using testing::Contains;
using testing::IsEmpty;

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
