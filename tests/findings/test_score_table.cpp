// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/score_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

class ScoreTable : public testing::Test {
 protected:
  MethodScores read(const std::string& text, const std::string& score = "accuracy") const {
    test::writeFile(file_, text);
    return readScores(file_, score);
  }
  test::Caught refusal(const std::string& text, const std::string& score = "accuracy") const {
    return test::caught([&] { read(text, score); });
  }

  test::ScratchFolder scratch_;
  const std::filesystem::path file_ = scratch_ / "scores.csv";
};

TEST_F(ScoreTable, ReadsARowATest) {
  const MethodScores scores = read("test,\"SVM, linear\",kNN\nday,0.5,1e-1\n\nnight,-2,3\n");
  EXPECT_THAT(scores.methods, ElementsAre("SVM, linear", "kNN"));
  EXPECT_THAT(scores.tests, ElementsAre("day", "night"));
  EXPECT_THAT(scores.values, ElementsAre(ElementsAre(0.5, 0.1), ElementsAre(-2, 3)));
}

TEST_F(ScoreTable, NamesHaveNoControlCharacters) {
  const MethodScores scores = read("test,a\x1b[31m,b\nt\xe2\x80\xae,1,2\n");
  EXPECT_THAT(scores.methods, ElementsAre("a\\x1B[31m", "b"));
  EXPECT_THAT(scores.tests.front(), testing::Not(testing::HasSubstr("\xe2\x80\xae")));
  EXPECT_THAT(refusal("test,a\x1b,b\nt,,1\n"), FailsWith(ErrorCode::insufficientData, "a\\x1B"));
}

TEST_F(ScoreTable, ReadsTheResultsOfAnExperimentInAnyOrder) {
  const std::string text =
      "classifier,descriptor,train,test,seconds,balanced_accuracy,accuracy\n"
      "svm,gist+esf,A,B,7,.6,.7\n"
      "knn,gist+esf,B,A,7,.1,.2\n"
      "knn,gist+esf,A,B,7,.3,.4\n"
      "svm,gist+esf,B,A,,.8,.9\n";
  const MethodScores scores = read(text);
  EXPECT_THAT(scores.methods, ElementsAre("gist+esf/svm", "gist+esf/knn"));
  EXPECT_THAT(scores.tests, ElementsAre("A→B", "B→A"));
  EXPECT_THAT(scores.values, ElementsAre(ElementsAre(.7, .4), ElementsAre(.9, .2)));
  EXPECT_THAT(read(text, "balanced_accuracy").values, ElementsAre(ElementsAre(.6, .3), ElementsAre(.8, .1)));
  EXPECT_THAT(refusal(text, "f1"), FailsWith(ErrorCode::unknownName, "\"f1\"", "seconds, balanced_accuracy"));
}

TEST_F(ScoreTable, SaysWhichMethodLacksWhichTest) {
  EXPECT_THAT(refusal("test,a,b\nt,1,2\nu,3,\n"), FailsWith(ErrorCode::insufficientData, "b in u;"));
  for (const char* absent : {"–", "nan", "n/a", " "})
    EXPECT_THAT(refusal(std::string("test,a,b\nt,1,") + absent + "\nu,3,4\n"),
                FailsWith(ErrorCode::insufficientData, "b in t;"));
  EXPECT_THAT(refusal("descriptor,classifier,train,test,accuracy\ng,s,A,B,1\ng,k,A,B,1\ng,s,B,A,1\n"),
              FailsWith(ErrorCode::insufficientData, "g/k in B→A;"));
  // Each method in a test of its own: the table would be as large as the square of the file.
  std::string apart = "descriptor,classifier,train,test,accuracy\n";
  for (int i = 0; i < 100000; ++i) {
    const std::string name = std::to_string(i);
    apart += name;
    apart += ",c,A,";
    apart += name;
    apart += ",1\n";
  }
  EXPECT_THAT(refusal(apart), FailsWith(ErrorCode::insufficientData, "0/c in A→5", "9999899995"));
}

TEST_F(ScoreTable, RefusesWhatIsNoTableOfScores) {
  EXPECT_THAT(refusal(""), FailsWith(ErrorCode::insufficientData, "scores.csv"));
  EXPECT_THAT(refusal("test,a,b\n"), FailsWith(ErrorCode::insufficientData, "scores.csv"));
  EXPECT_THAT(refusal("test\nx\n"), FailsWith(ErrorCode::malformedFile, "scores.csv"));
  EXPECT_THAT(refusal("test,a,\nt,1,2\n"), FailsWith(ErrorCode::malformedFile, "3"));
  EXPECT_THAT(refusal("test,a,a\nt,1,2\n"), FailsWith(ErrorCode::malformedFile, "\"a\""));
  EXPECT_THAT(refusal("test,a,b\nt,1\n"), FailsWith(ErrorCode::malformedFile, "scores.csv:2: 2", "3"));
  EXPECT_THAT(refusal("test,a,b\nt,1,2\nt,3,4\n"),
              FailsWith(ErrorCode::malformedFile, "scores.csv:3", "\"t\""));
  for (const char* wrong : {"high", "1,5x", "inf", "91%", "0x", "1 2"})
    EXPECT_THAT(refusal(std::string("test,a,b\nt,1,\"") + wrong + "\"\n"),
                FailsWith(ErrorCode::malformedFile, "scores.csv:2", std::string("\"") + wrong + "\""));
  EXPECT_THAT(refusal("descriptor,classifier,train,test,accuracy\ng,s,A,B,1\ng,s,A,B,1\n"),
              FailsWith(ErrorCode::malformedFile, "scores.csv:3", "g/s in A→B", "2"));
  EXPECT_THAT(refusal("test,a,b\n\"t,1,2\n"), FailsWith(ErrorCode::malformedFile, "scores.csv:2"));
  EXPECT_THAT([&] { readScores(scratch_ / "missing.csv"); },
              FailsWith(ErrorCode::fileNotFound, "missing.csv"));
}

}  // namespace
}  // namespace estancia
