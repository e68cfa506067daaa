// Labels found by words: rankings, files of queries, and the queries of the project with the real WordNet.
// SPDX-License-Identifier: Apache-2.0
#include "words/words_experiment.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "estancia/core/progress.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "words/average_precision.hpp"
#include "words/label_finders.hpp"
#include "words/word_queries.hpp"

namespace estancia::experiments {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::writeFile;
using testing::DoubleNear;
using testing::ElementsAre;

constexpr double exact = 1e-12;

TEST(AveragePrecision, IsThatOfAHandComputedRanking) {
  const std::vector<double> scores{0.1, 0.9, 0.8, 0.5, 0.3};  // the ranking is 1, 2, 3, 4, 0
  EXPECT_THAT(averagePrecision(scores, {1}), DoubleNear(1, exact));
  EXPECT_THAT(averagePrecision(scores, {0}), DoubleNear(1.0 / 5, exact));
  EXPECT_THAT(averagePrecision(scores, {1, 3}), DoubleNear((1 + 2.0 / 3) / 2, exact));
  EXPECT_THAT(averagePrecision(scores, {0, 2, 4}), DoubleNear((1.0 / 2 + 2.0 / 4 + 3.0 / 5) / 3, exact));
}

TEST(AveragePrecision, IsTheMeanOverAllOrdersOfTiedScores) {
  const std::vector<double> scores{1, 0.5, 0.5, 0.5, 0.5, 0};
  for (const std::vector<std::size_t>& answers :
       {std::vector<std::size_t>{2}, {1, 3}, {0, 2, 4}, {1, 2, 3, 4}, {1, 5}, {0, 5}}) {
    std::vector<double> order{1, 2, 3, 4};
    double sum = 0;
    int orders = 0;
    do {
      sum += averagePrecision({9, order[0], order[1], order[2], order[3], 0}, answers);
      ++orders;
    } while (std::ranges::next_permutation(order).found);
    ASSERT_EQ(orders, 24);
    EXPECT_THAT(averagePrecision(scores, answers), DoubleNear(sum / orders, exact));
  }
}

TEST(AveragePrecision, NeedsAnswersAmongTheItems) {
  EXPECT_THAT([] { averagePrecision({1, 2}, {}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { averagePrecision({1, 2}, {2}); }, FailsWith(ErrorCode::invalidInput));
}

/// A thousand labels "class 0" …, after so many others.
Vocabulary thousand(const std::vector<std::string>& before = {}) {
  std::vector<std::string> labels = before;
  for (int i = 0; i < 1000; ++i) labels.push_back(fmt::format("class {}, thing {}", i, i % 3));
  return Vocabulary(labels);
}

std::vector<WordQuery> read(const std::string& rows, const Vocabulary& vocabulary) {
  const test::ScratchFolder folder;
  writeFile(folder / "q.csv", "kind,query,labels\n" + rows);
  return readWordQueries(folder / "q.csv", vocabulary);
}

TEST(WordQueries, NameLabelsByTheirFirstSynonymAndByNumber) {
  const Vocabulary vocabulary({"n00000001 cup, mug", "pan", "crane", "crane", "couch, sofa"});
  const auto queries = read("synonym,drink from,cup\nodd kind,\"cook, fry\",pan|cup\n", vocabulary);
  ASSERT_EQ(queries.size(), 2U);
  EXPECT_EQ(queries[0].kind, "synonym");
  EXPECT_EQ(queries[0].text, "drink from");
  EXPECT_THAT(queries[0].answers, ElementsAre(0));
  EXPECT_EQ(queries[1].kind, "odd kind");
  EXPECT_EQ(queries[1].text, "cook, fry");
  EXPECT_THAT(queries[1].answers, ElementsAre(0, 1));
}

TEST(WordQueries, CountImageNetsClassesWithoutTheBackground) {
  EXPECT_THAT(read("k,q,#3|class 1|#998-#999|#0\n", thousand())[0].answers, ElementsAre(0, 1, 3, 998, 999));
  EXPECT_THAT(read("k,q,#3|class 1|#998-#999|#0\n", thousand({"background"}))[0].answers,
              ElementsAre(1, 2, 4, 999, 1000));
}

TEST(WordQueries, TellWhatIsWrongByFileAndLine) {
  const std::pair<std::string, std::string> rows[] = {
      {"k,q,class 1\nk,r,class 1000\n", "q.csv:3: no label begins with \"class 1000\""},
      {"k,q,thing 1\n", "\"thing 1\""},
      {"k,q,#\n", "q.csv:2: # "},
      {"k,q,#1000\n", "#1000"},
      {"k,q,#-1\n", "#-1"},
      {"k,q,#x\n", "#x"},
      {"k,q,#5x\n", "#5x"},
      {"k,q,#7-#5\n", "#7-#5"},
      {"k,q,#7-9\n", "#7-9"},
      {"k,q,#7-#1000\n", "#7-#1000"},
      {"k,q,#7-\n", "#7-"},
      {"k,q,#99999999999999999999999\n", "#99999999999999999999999"},
      {"k,q,\n", "q.csv:2: the column \"labels\""},
      {"k,q,class 1|\n", "q.csv:2: "},
      {"k,q,class 1||class 2\n", "q.csv:2: "},
      {"k,q,class 1|#0-#3\n", "#0-#3"},
      {"k,,class 1\n", "q.csv:2: the column \"query\""},
      {",q,class 1\n", "q.csv:2: the column \"kind\""},
      {"k,q,class 1\nk,s,class 1\nother,q,class 2\n", "q.csv:4: \"q\" is asked in line 2"},
      {"k,q\n", "q.csv:2: "}};
  for (const auto& [row, told] : rows) {
    const auto reading = [&text = row] { read(text, thousand()); };
    EXPECT_THAT(reading, FailsWith(ErrorCode::malformedFile, told, "q.csv:")) << row;
  }
  EXPECT_THAT(
      [] {
        read("k,q,crane\n", Vocabulary({"crane", "crane"}));
      },
      FailsWith(ErrorCode::malformedFile, "q.csv:2: 2", "\"crane\""));
  EXPECT_THAT(
      [] {
        read("k,q,#1\n", Vocabulary({"cup", "pan"}));
      },
      FailsWith(ErrorCode::malformedFile, "q.csv:2: #1", "1000", "2 labels"));
  EXPECT_THAT([] { read("", thousand()); }, FailsWith(ErrorCode::insufficientData, "q.csv"));
}

/// ESTANCIA_WORDNET, as it was before afterwards.
class OtherWordNet {
 public:
  explicit OtherWordNet(const fs::path& folder) {
    if (const char* set = std::getenv("ESTANCIA_WORDNET")) before_ = set;
    setenv("ESTANCIA_WORDNET", folder.c_str(), 1);
  }
  ~OtherWordNet() {
    before_ ? setenv("ESTANCIA_WORDNET", before_->c_str(), 1) : unsetenv("ESTANCIA_WORDNET");
  }
  OtherWordNet(const OtherWordNet&) = delete;
  OtherWordNet& operator=(const OtherWordNet&) = delete;

 private:
  std::optional<std::string> before_;
};

/// A model of seven labels, and four queries for them.
class Words : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(scratch_ / "seven");
    writeFile(
        scratch_ / "seven/labels.txt",
        "studio couch, day bed\nrefrigerator, icebox\ncoffee mug\nespresso maker\nstove\nmouse, computer "
        "mouse\ntabby, tabby cat\n");
    writeFile(scratch_ / "seven/h.csv", "1.png,stove\n");
    writeFile(scratch_ / "seven/model.toml",
              "name = \"seven\"\ntype = \"human\"\nfile = \"h.csv\"\nlabels = \"labels.txt\"\n");
    writeFile(scratch_ / "q.csv",
              "kind,query,labels\nsynonym,fridge,refrigerator\nsynonym,stove,stove\n"
              "hypernym,animal,tabby\nmisspelt,cofee,coffee mug|espresso maker\n");
    writeFile(scratch_ / "words.toml", "type = \"words\"\nqueries = \"q.csv\"\nmodels = [\"seven\"]\n");
  }

  Findings run() {
    return runExperiment({scratch_ / "words.toml"},
                         {scratch_ / "out", {(scratch_ / "seven").string()}, {"", 1}, nullptr}, progress_);
  }

  test::ScratchFolder scratch_;
  Progress progress_;
};

/// The values of one row of a table, by the names of table and row.
std::vector<double> row(const Findings& findings, const std::string& title, const std::string& name) {
  for (const auto& section : findings.sections)
    if (const auto* table = std::get_if<ResultTable>(&section); table != nullptr && table->title == title)
      for (const ResultTable::Row& row : table->rows)
        if (row.name == name) {
          std::vector<double> values;
          for (const auto& value : row.values) values.push_back(value.value());
          return values;
        }
  ADD_FAILURE() << "no " << title << ", " << name;
  return {};
}

TEST_F(Words, AreMeasuredMethodByMethod) {
  const Findings findings = run();
  // Odd queries: "stove" is a name; "cofee" is none, and only search corrects it.
  const std::string odd = "seven, odd queries (reported)";
  EXPECT_THAT(row(findings, odd, "synonym"), ElementsAre(1, 1, 1, 1, 1, 1));
  const std::vector<double> misspelt = row(findings, odd, "misspelt");
  ASSERT_EQ(misspelt.size(), 6U);
  const double chance = averagePrecision(std::vector<double>(7, 0), {2, 3});
  for (std::size_t method = 1; method < 5; ++method) EXPECT_THAT(misspelt[method], DoubleNear(chance, exact));
  EXPECT_EQ(misspelt[5], 1);
  EXPECT_EQ(row(findings, odd, "(all)")[0], 2);

  const std::string even = "seven, even queries (weights were chosen on them)";
  EXPECT_EQ(row(findings, even, "synonym")[5], 1) << "a fridge is a refrigerator";
  EXPECT_LT(row(findings, even, "hypernym")[1], 1) << "no label is called animal";
  EXPECT_EQ(row(findings, even, "hypernym")[3], 1) << "a tabby is a kind of animal";
  EXPECT_THAT(row(findings, odd + ": labels returned", "synonym"), ElementsAre(1, 1, 1, 1, 1, 1))
      << "queries, answers, returned, precision, recall, F1";

  const std::string csv = test::readFile(scratch_ / "out/results.csv");
  EXPECT_THAT(csv,
              testing::StartsWith(
                  "model,half,kind,query,method,answers,average_precision,returned,correct,milliseconds\n"
                  "seven,even,synonym,fridge,matching,1,"));
  EXPECT_THAT(csv, testing::HasSubstr("\nseven,odd,synonym,stove,search,1,1,1,1,"));
}

TEST_F(Words, NeedWordNet) {
  const OtherWordNet none(scratch_ / "nowhere");
  EXPECT_THAT([&] { run(); }, FailsWith(ErrorCode::missingDependency, "ESTANCIA_WORDNET", "wordnet-base"));
}

TEST_F(Words, NeedQueriesThatAreThere) {
  fs::remove(scratch_ / "q.csv");
  EXPECT_THAT([&] { run(); }, FailsWith(ErrorCode::fileNotFound, "q.csv"));
  writeFile(scratch_ / "words.toml", "type = \"words\"\n");
  EXPECT_THAT([&] { run(); }, FailsWith(ErrorCode::malformedFile, "words.toml", "queries"));
}

/// Mean average precision of search on the odd queries of the project, which no weight was chosen on.
TEST(WordsOfTheProject, FindLabels) {
  const auto models = test::findTestModels();
  ESTANCIA_NEEDS(models, "the test networks are missing (ESTANCIA_TEST_MODELS)");
  const auto folder = findWordNet();
  ASSERT_TRUE(folder) << "install wordnet-base";
  const Vocabulary vocabulary = readVocabulary(*models / "imagenet_1001.txt");
  const auto queries =
      readWordQueries(fs::path(ESTANCIA_LAB_DIR) / "experiments/words/queries.csv", vocabulary);
  ASSERT_EQ(queries.size(), 289U);
  const WordNet wordNet = readWordNet(*folder);
  const LabelFinders finders(vocabulary, wordNet);
  double sum = 0, count = 0;
  for (std::size_t q = 1; q < queries.size(); q += 2, ++count)
    sum += averagePrecision(finders.score(LabelFinders::methods().size() - 1, queries[q].text),
                            queries[q].answers);
  EXPECT_GE(sum / count, 0.60);
}

}  // namespace
}  // namespace estancia::experiments
