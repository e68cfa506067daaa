// `estancia compare` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using nlohmann::json;
using testing::StartsWith;
namespace fs = std::filesystem;

class CompareCommand : public testing::Test {
 protected:
  void SetUp() override {
    // In each of 12 tests ESF/RFs beats GIST/SVM by a little, and PHOG/kNN is far behind.
    std::string wide = "test,GIST/SVM,PHOG/kNN,ESF/RFs\n";
    std::string rows = "descriptor,classifier,train,test,accuracy,balanced_accuracy\n";
    for (int t = 0; t < 12; ++t) {
      const std::string test = std::to_string(t), tenth = "0." + std::to_string(20 + t);
      const std::string good = t % 3 == 0 ? "0.91" : "0.89";
      wide += "A→" + test;
      wide += ",0.90," + tenth;
      wide += "," + good;
      wide += "\n";
      for (const auto& [method, score] : {std::pair{std::string("GIST,SVM"), std::string("0.90")},
                                          {"PHOG,kNN", tenth},
                                          {"ESF,RFs", good}}) {
        rows += method + ",A,";
        rows += test + "," + score;
        rows += ",0.5\n";
      }
    }
    writeFile(wide_, wide);
    writeFile(long_, rows);
  }

  json jsonOf(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "compare");
    arguments.emplace_back("--json");
    const auto result = run(arguments);
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return json::parse(result.out);
  }

  void refuses(std::vector<std::string> arguments, ErrorCode code) const {
    arguments.insert(arguments.begin(), "compare");
    const auto result = run(arguments);
    EXPECT_THAT(result, FailsWith(code));
    EXPECT_EQ(result.out, "");
  }

  ScratchFolder scratch_;
  const std::string wide_ = scratch_ / "wide.csv", long_ = scratch_ / "results.csv";
};

TEST_F(CompareCommand, TakesTheResultsOfAnExperiment) {
  json wide = jsonOf({wide_}), rows = jsonOf({long_});
  EXPECT_EQ(rows["tests"][0], "A→0");
  EXPECT_EQ(wide, rows);
  EXPECT_EQ(wide["control"], "GIST/SVM");
  EXPECT_EQ(wide["methods"].size(), 3U);
  EXPECT_TRUE(wide["methods"][0]["p"].is_null());
  EXPECT_EQ(wide["methods"][2]["rejected"], true);
  EXPECT_EQ(wide["pairs"].size(), 2U);
  EXPECT_NEAR(wide["friedman"]["chi_squared"].get<double>(), 56.0 / 3, 1e-9);
  const json equal = jsonOf({long_, "--score", "balanced_accuracy"});
  EXPECT_EQ(equal["differ"], false);
  EXPECT_EQ(equal["friedman"]["p"], 1);
  EXPECT_FALSE(equal["friedman"]["undefined"].get<std::string>().empty());
}

TEST_F(CompareCommand, TakesSomeOfTheTests) {
  EXPECT_EQ(jsonOf({wide_, "--only", "→1", "--without", "→11"})["tests"], json({"A→1", "A→10"}));
  refuses({wide_, "--only", "B→"}, ErrorCode::insufficientData);
}

TEST_F(CompareCommand, WritesTablesPageAndDiagram) {
  const fs::path out = scratch_ / "some" / "where";
  const auto result = run({"compare", wide_, "--post-hoc", "shaffer", "-o", out.string()});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  refuses({wide_, "-o", out.string()}, ErrorCode::fileExists);
  EXPECT_THAT(readFile(out / "comparison.md"),
              StartsWith("# 3 methods compared over 12 tests\n\n3 methods differ"));
  EXPECT_THAT(readFile(out / "comparison.csv"),
              StartsWith("method,p-value,rejected,rank,win,tie,loss\nGIST/SVM,,no,1.3333333333333333,,,\n"));
  EXPECT_NE(readFile(out / "comparison.tex").find("\\begin{tabular}{lrrrrrr}\n"), std::string::npos);
  EXPECT_THAT(readFile(out / "comparison.svg"), StartsWith("<?xml"));
  const std::string page = readFile(out / "comparison.html");
  EXPECT_NE(page.find("class=\"group\""), std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(out), fs::directory_iterator()), 5);
}

TEST_F(CompareCommand, SaysWhatIsWrong) {
  refuses({(scratch_ / "missing.csv").string()}, ErrorCode::fileNotFound);
  refuses({wide_, "--control", "ESF"}, ErrorCode::unknownName);
  refuses({wide_, "--post-hoc", "tukey"}, ErrorCode::unknownName);
  refuses({wide_, "--alpha", "5"}, ErrorCode::invalidOption);
  refuses({long_, "--score", "f1"}, ErrorCode::unknownName);
  refuses({wide_, "-o", wide_}, ErrorCode::fileUnwritable);
  writeFile(wide_, "test,a,b\nx,1,2\n");
  refuses({wide_}, ErrorCode::insufficientData);
}

TEST_F(CompareCommand, ItsExampleWorks) {
  const std::string help = run({"compare", "--help"}).out;
  const auto head = help.find("test,GIST/SVM");
  ASSERT_NE(head, std::string::npos);
  writeFile(wide_, help.substr(head));
  EXPECT_EQ(jsonOf({wide_})["control"], "ESF/forest");
}

}  // namespace
}  // namespace estancia::test
