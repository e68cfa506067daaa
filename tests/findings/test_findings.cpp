// What is found of comparisons, confusions and labels, and the tables of scores and results around it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "estancia/core/error.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/findings/comparison_findings.hpp"
#include "estancia/findings/confusion_findings.hpp"
#include "estancia/findings/label_findings.hpp"
#include "estancia/findings/object_sheet.hpp"
#include "estancia/findings/result_table.hpp"
#include "estancia/findings/score_table.hpp"
#include "support/errors.hpp"
#include "support/golden_findings.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::HasSubstr;

/// a is always a little better than b; c is far behind but for the first `cAhead` tests, where it is best.
MethodScores sampleScores(int tests, int cAhead = 0) {
  MethodScores scores{{"c", "a", "b"}, {}, {}};
  for (int t = 0; t < tests; ++t) {
    scores.tests.push_back(std::to_string(t));
    scores.values.push_back({t < cAhead ? 0.95 : 0.1, 0.9, 0.8});
  }
  return scores;
}

Findings compare(const MethodScores& scores, ComparisonOptions options = {}) {
  return comparisonFindings(compareMethods(scores, options));
}

TEST(ComparisonFindings, AreWholeFiles) {
  test::expectGolden("comparison-different", compare(sampleScores(20)));
  test::expectGolden("comparison-equal", compare(sampleScores(9, 3)));
  ComparisonOptions options;
  options.control = "b";
  test::expectGolden("comparison-control", compare(sampleScores(20), options));
  test::expectGolden("comparison-few", compare(sampleScores(4, 2)));
  test::expectGolden("comparison-two", compare({{"a", "b"}, {"t", "u"}, {{1, 0}, {2, 0}}}));
  options = {};
  options.postHoc = PostHoc::nemenyi;
  test::expectGolden("comparison-nemenyi", compare(sampleScores(20), options));
}

TEST(ComparisonFindings, SayThatEqualScoresDoNotDiffer) {
  test::expectGolden("comparison-same", compare({{"a", "b"}, {"t", "u"}, {{1, 1}, {1, 1}}}));
  test::expectGolden("comparison-one", compare({{"a"}, {"t"}, {{1}}}));
}

TEST(ComparisonFindings, NoPIsZero) {
  const Findings findings = compare(sampleScores(1000));
  for (const auto& [name, value] : findings.facts)
    EXPECT_THAT(value, testing::Not(testing::ContainsRegex("p = (0$|0[^.]|<)"))) << name;
  EXPECT_EQ(pText(0), "p < 1e-300");
  EXPECT_EQ(pText(1e-299), "p = 1.0e-299");
  EXPECT_EQ(pText(0.0123), "p = 0.012");
  EXPECT_EQ(cellText(comparisonTable(compareMethods(sampleScores(20))).columns[0], 0.0), "< 1e-300");
}

TEST(ConfusionFindings, AreAWholeFile) {
  const Confusion confusion =
      confusionOf({"hall", "hall", "lab", "lab", "lab"}, {"hall", "lab", "lab", "lab", "attic"});
  EXPECT_EQ(rightOf(confusion), 3U);
  test::expectGolden("confusion", findingsOf(confusion, "rooms", {{"Sequence", "tour"}}));
  EXPECT_THAT([] { findingsOf(confusionOf({}, {}), "rooms", {}); }, test::FailsWith(ErrorCode::mismatch));
}

template <class Section>
const Section& only(const Findings& findings) {
  for (const auto& section : findings.sections)
    if (const auto* found = std::get_if<Section>(&section)) return *found;
  throw Error(ErrorCode::insufficientData, "no such section");
}

DescriptorSequence recordingOf(const std::vector<std::vector<float>>& rows) {
  DescriptorSequence recording{
      Vocabulary({"desk", "mug, cup", "sofa", "bed"}), "model-1", {}, DescriptorMatrix(4)};
  for (const auto& row : rows) {
    recording.frames.push_back({"frame" + std::to_string(recording.frames.size()), {}, {}, ""});
    recording.descriptors.append(row);
  }
  return recording;
}

TEST(LabelFindings, CountTheImagesThatHaveALabel) {
  const DescriptorSequence recording =
      recordingOf({{0.6F, 0.4F, 0, 0}, {0.5F, 0.3F, 0.2F, 0}, {0.7F, 0.2F, 0.1F, 0}});
  const Findings findings = labelFindings(recording, {}, {.labelsPerImage = 2});
  EXPECT_THAT(findings.summary, testing::StartsWith("2 of 4 labels occur; the 1 most frequent"));
  const auto& table = only<ResultTable>(findings);
  ASSERT_EQ(table.rows.size(), 2U) << "sofa is the third of every image, and nobody has a bed";
  EXPECT_EQ(table.rows[0].name, "desk");
  EXPECT_EQ(table.rows[1].name, "mug");
  EXPECT_EQ(*table.rows[0].values[0], 3);
  EXPECT_NEAR(*table.rows[1].values[2], 0.3, 1e-6);
  const auto& curve = only<LineChart>(findings);
  EXPECT_THAT(curve.lines[0].y, testing::ElementsAre(testing::DoubleEq(0.5), testing::DoubleEq(1)));
  EXPECT_THAT(only<WordClouds>(findings).clouds[0].words, testing::SizeIs(2));
  EXPECT_FALSE(std::ranges::any_of(
      findings.sections, [](const auto& section) { return std::holds_alternative<Images>(section); }));
}

TEST(LabelFindings, ShowTheImagesThatShowALabelBest) {
  const DescriptorSequence recording =
      recordingOf({{0.1F, 0, 0, 0}, {0.9F, 0, 0, 0}, {0.5F, 0, 0, 0}, {0.2F, 0, 0, 0}});
  const ImageOfFrame image = [](std::size_t frame) {
    return frame == 2 ? std::vector<unsigned char>() : std::vector<unsigned char>{1};
  };
  const Findings findings = labelFindings(recording, image);
  const auto& shown = only<Images>(findings).images;
  ASSERT_EQ(shown.size(), 2U) << "frame2 has no image";
  EXPECT_EQ(shown[0].caption, "desk 0.90, frame1");
  EXPECT_EQ(shown[1].caption, "desk 0.20, frame3");
}

TEST(LabelFindings, OfNothingAreRefused) {
  EXPECT_THAT(
      [] {
        labelFindings(recordingOf({{0, 0, 0, 0}}));
      },
      test::FailsWith(ErrorCode::insufficientData));
}

class PaintedViews : public ObjectViews {
 public:
  std::string name() const override { return "painted"; }
  std::size_t size() const override { return views_.size(); }
  const ObjectView& view(std::size_t i) const override { return views_[i]; }
  PointCloud cloud(std::size_t /*i*/) const override { return {}; }
  ObjectImage image(std::size_t i) const override {
    return {cv::Mat(40, 40, CV_8UC3, cv::Scalar::all(60.0 * static_cast<double>(i))), {10, 10, 20, 20}, {}};
  }

 private:
  std::vector<ObjectView> views_{{"a0", "a", "mug", "", "", true, false},
                                 {"a1", "a", "mug"},
                                 {"a2", "a", "mug"},
                                 {"b0", "b", "", "", "", false, true}};
};

TEST(ObjectSheet, ShowsTheBestWholeViewOfEachObject) {
  const PaintedViews views;
  DescriptorSequence labels = recordingOf({{0, 1, 0, 0}, {0.5F, 0.5F, 0, 0}, {0, 0.6F, 0.4F, 0}});
  for (std::size_t i = 0; i < 3; ++i) labels.frames[i].name = views.view(i).name;
  const Images sheet = objectSheet(views, &labels);
  ASSERT_EQ(sheet.images.size(), 2U);
  EXPECT_EQ(sheet.images[0].caption, "a (mug): mug 70 %, 3 views");
  EXPECT_EQ(sheet.images[1].caption, "b: 1 view") << "it has no labels";
  const auto gray = [&](std::size_t i) {
    return cv::imdecode(sheet.images[i].file, cv::IMREAD_COLOR).at<cv::Vec3b>(0, 0)[0];
  };
  EXPECT_NEAR(gray(0), 120, 3) << "a0 is flat, a1 less of a mug";
  EXPECT_NEAR(gray(1), 180, 3);
  EXPECT_EQ(objectSheet(views).images[0].caption, "a (mug): 3 views");
}

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
  EXPECT_THAT(refusal("test,a,\nt,1,2\n"), FailsWith(ErrorCode::malformedFile));
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

ResultTable sampleTable() {
  using Best = ResultTable::Best;
  using Form = ResultTable::Form;
  return {"Against ESF",
          "Smaller is better.",
          "method",
          {{"p", 4, Best::none, Form::scientific},
           {"rejected", 0, Best::none, Form::yesNo},
           {"rank", 2, Best::smallest}},
          {{"ESF", {std::nullopt, 0.0, 2.7}}, {"A→B", {0.000047705, 1.0, 10.4}}}};
}

TEST(ResultTableText, LinesUpInATerminal) {
  EXPECT_EQ(textTable(sampleTable()),
            "method           p   rejected       rank\n"
            "ESF              –         no       2.70\n"
            "A→B     4.7705e-05        yes      10.40\n");
}

TEST(ResultTableText, IsMarkdown) {
  EXPECT_EQ(markdownTable(sampleTable()),
            "| method | p | rejected | rank |\n"
            "| --- | ---: | ---: | ---: |\n"
            "| ESF | – | no | **2.70** |\n"
            "| A→B | 4.7705e-05 | yes | 10.40 |\n");
}

TEST(ResultTableText, IsCsvWithAllDigits) {
  EXPECT_EQ(csvTable(sampleTable()), "method,p,rejected,rank\nESF,,no,2.7\nA→B,4.7705e-05,yes,10.4\n");
}

TEST(ResultTableText, IsLatexWithoutPackages) {
  EXPECT_EQ(latexTable(sampleTable()),
            "% Against ESF\n% Smaller is better.\n"
            "\\begin{tabular}{lrrr}\n\\hline\n"
            "method & p & rejected & rank \\\\\n\\hline\n"
            "ESF & -- & no & \\textbf{2.70} \\\\\n"
            "A$\\rightarrow$B & 4.7705e-05 & yes & 10.40 \\\\\n"
            "\\hline\n\\end{tabular}\n");
}

TEST(ResultTableText, SaysNothingOfWhatIsNotThere) {
  ResultTable table = sampleTable();
  table.title = table.caption = "";
  EXPECT_EQ(latexTable(table).find("\\begin"), 0U);
  EXPECT_EQ(cellText(table.columns[0], -1.0), "-1.0000e+00");
  for (ResultTable::Row& row : table.rows) row.values[2].reset();
  EXPECT_EQ(markdownTable(table).find("**"), std::string::npos) << "none is the best";
}

TEST(ResultTableText, SurvivesAnyName) {
  ResultTable table = sampleTable();
  const std::string hostile = "a|b\n\\end{x}_$&#%^~<i>[*`\"\x1b[31m,é\xFF";
  table.title = table.caption = table.rowsAre = table.columns[0].name = table.rows[0].name = hostile;

  for (const std::string& text : {markdownTable(table), latexTable(table), textTable(table)}) {
    EXPECT_EQ(text.find('\x1b'), std::string::npos);
    EXPECT_NE(text.find("é"), std::string::npos);
  }
  const std::string markdown = markdownTable(table), latex = latexTable(table);
  EXPECT_EQ(std::count(markdown.begin(), markdown.end(), '\n'), 4);
  EXPECT_THAT(markdown, HasSubstr("| a\\|b \\\\end\\{x\\}\\_\\$\\&\\#%^\\~\\<i\\>\\[\\*\\`\""));
  EXPECT_EQ(std::count(latex.begin(), latex.end(), '\n'), 10);
  EXPECT_THAT(latex, HasSubstr("\na\\textbar{}b \\textbackslash{}end\\{x\\}\\_\\$\\&\\#\\%\\textasciicircum{}"
                               "\\textasciitilde{}\\textless{}i\\textgreater{}{[}{*}`''"));

  const test::ScratchFolder scratch;
  test::writeFile(scratch / "table.csv", csvTable(table));
  const auto rows = io::readCsv(scratch / "table.csv");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].cells[0], hostile);
  EXPECT_THAT(rows[1].cells, ElementsAre(hostile, "", "no", "2.7"));
}

}  // namespace
}  // namespace estancia
