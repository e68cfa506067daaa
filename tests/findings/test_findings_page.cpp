// Findings as a page and as files.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>
#include <regex>

#include "estancia/core/error.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/findings/findings_page.hpp"
#include "estancia/findings/result_table.hpp"
#include "support/errors.hpp"
#include "support/html_checks.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::count;
using test::FailsWith;
using test::Html;
using test::readFile;
using testing::ElementsAre;

Findings samplePage() {
  Findings findings;
  findings.title = "Which one?";
  findings.summary = "That one.";
  findings.facts = {{"Sequence", "tour"}};
  findings.notes = {"kitchen was left out"};
  using Best = ResultTable::Best;
  findings.sections.emplace_back(
      ResultTable{"Ranks",
                  "Lower is better.",
                  "model",
                  {{"rank", 2, Best::smallest}, {"wins", 0, Best::largest}, {"ties", 0, Best::none}},
                  {{"a", {1.5, 7.0, 1.0}}, {"b", {1.501, std::nullopt, 1.0}}, {"c", {3.0, 2.0, 1.0}}}});
  findings.sections.emplace_back(LineChart{
      "Curves", "", "k", "left", false, {1, 2, 3, 4}, {{"a", {100, 50, 25, 0}}, {"b", {80, 60, NAN, 10}}}});
  findings.sections.emplace_back(StackedBars{"Bars", "", {"wins", "losses"}, {{"a", {3, 1}}, {"b", {0, 4}}}});
  findings.sections.emplace_back(HeatTable{"Heat", "", {"hall", "lab"}, {0.25, 1, 1, NAN}, 2});
  return findings;
}

TEST(FindingsPage, ShowsTablesCurvesBarsAndNotes) {
  const std::string html = renderFindingsPage(samplePage());
  const Html page(html);
  EXPECT_THAT(page.texts("h1"), ElementsAre("Which one?"));
  EXPECT_THAT(page.texts("p.answer"), ElementsAre("That one."));
  EXPECT_THAT(page.texts("h3"), ElementsAre("Ranks", "Curves", "Bars", "Heat"));
  EXPECT_THAT(page.texts("p.note"), ElementsAre("Lower is better.", "kitchen was left out"));
  EXPECT_THAT(page.texts("dd"), ElementsAre("tour"));
  EXPECT_THAT(page.values("i.p0", "style"), testing::Contains("width:75%"));
  EXPECT_EQ(count(html, "<td"), 9U + 4U);
  EXPECT_EQ(count(html, "<path class=\"curve"), 2U + 2U) << "curves and their legend";
}

TEST(FindingsPage, PointsOutTheBestAndWhatReadsTheSame) {
  const std::string html = renderFindingsPage(samplePage());
  EXPECT_EQ(count(html, "class=\"best\">1.50<"), 2U) << "1.500 and 1.501 read the same";
  EXPECT_EQ(count(html, "class=\"best\">7<"), 1U);
  EXPECT_EQ(count(html, "class=\"best\""), 3U);
  EXPECT_EQ(count(html, "<td>–</td>"), 1U);
}

TEST(FindingsPage, PointsOutWhatBeatsARivalAndHowHotAValueIs) {
  Findings findings = samplePage();
  auto& table = std::get<ResultTable>(findings.sections[0]);
  table.columns[1].beats = 2;
  table.hottest = 7;
  table.rows.push_back({"d", {4.0, 2.0, std::nullopt}});
  table.caption.clear();
  const std::string html = renderFindingsPage(findings);
  EXPECT_EQ(count(html, "class=\"best beats\""), 1U) << "7 > 1, and the most";
  EXPECT_EQ(count(html, "class=\"beats\""), 1U) << "2 > 1";
  EXPECT_EQ(count(html, "class=\"best\""), 2U);
  EXPECT_EQ(Html(html).texts("p.scale").front(), "0.007.00");
  EXPECT_THAT(Html(html).texts("p.note"), ElementsAre("kitchen was left out"));
}

/// An image of one color as a PNG.
std::vector<unsigned char> png() {
  const test::ScratchFolder scratch;
  writePng(cv::Mat(4, 4, CV_8UC3, cv::Scalar(10, 20, 30)), scratch / "a.png");
  const std::string bytes = test::readFile(scratch / "a.png");
  return {bytes.begin(), bytes.end()};
}

TEST(FindingsPage, ShowsImagesAndClouds) {
  Findings findings;
  findings.sections.emplace_back(Images{
      "Right",
      "Of the test.",
      {{png(), "a mug"}, {encodeImage(cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(9))), test::hostileText}}});
  findings.sections.emplace_back(
      WordClouds{"Clouds", "", {{"mug 1", {{"cup", 0.5}, {test::hostileText, 0.1}}}, {"none", {}}}});
  const std::string html = renderFindingsPage(findings);
  test::expectWellFormed(html);
  test::expectNothingFromOutside(html);
  const Html page(html);
  EXPECT_THAT(page.texts("h3"), ElementsAre("Right", "Clouds"));
  EXPECT_THAT(page.texts("p.note"), ElementsAre("Of the test."));
  EXPECT_THAT(page.values("img", "alt"), ElementsAre("a mug", testing::_));
  EXPECT_TRUE(page.values("img", "src")[0].starts_with("data:image/png;base64,"));
  EXPECT_TRUE(page.values("img", "src")[1].starts_with("data:image/jpeg;base64,"));
  EXPECT_THAT(page.texts("text"), testing::Contains("cup"));
  EXPECT_THAT(page.texts("figcaption"), testing::Contains("mug 1"));
  EXPECT_EQ(count(html, "class=\"gallery\""), 2U);
  std::get<Images>(findings.sections[0]).wide = true;
  EXPECT_EQ(count(renderFindingsPage(findings), "class=\"gallery wide\""), 1U);
  std::get<WordClouds>(findings.sections[1]).clouds.pop_back();
  EXPECT_EQ(count(renderFindingsPage(findings), "class=\"gallery wide\""), 2U) << "a cloud that is alone";
  std::get<Images>(findings.sections[0]).images[0].file = {'<', 's', 'v', 'g'};
  EXPECT_THAT([&] { renderFindingsPage(findings); }, FailsWith(ErrorCode::unsupportedFile, "a mug"));
}

TEST(FindingsPage, DrawsAMatrixAsHeatBetweenItsOwnExtremes) {
  const std::string html = renderFindingsPage(samplePage());
  EXPECT_GE(count(html, "background:#440154;color:#fff"), 1U);
  EXPECT_EQ(count(html, "background:#fde725;color:#000\" title=\"hall · lab: 1.00\">1.00<"), 1U);
  EXPECT_THAT(Html(html).texts("td.unknown"), ElementsAre("–"));
  Findings large;
  large.sections.emplace_back(HeatTable{"Heat", "", std::vector<std::string>(21, "x"),
                                        std::vector<double>(std::size_t{21} * 21, 0.5), 2});
  EXPECT_EQ(count(renderFindingsPage(large), ">0.50</td>"), 0U) << "no room for numbers";
  EXPECT_EQ(count(renderFindingsPage(large), "x · x: 0.50"), 21U * 21U);
  large.sections = {HeatTable{"Heat", "", {"a"}, {NAN}, 2}, HeatTable{"Heat", "", {}, {}, 2}};
  EXPECT_FALSE(Html(renderFindingsPage(large)).mentions("inf"));
}

TEST(FindingsPage, NeedsNoNetworkAndHasNoForeignMarkup) {
  Findings findings = samplePage();
  const std::string hostile = "</title><script>alert(1)</script>\"'&<img src=x>\xFF";
  findings.title = findings.summary = hostile;
  findings.facts = {{hostile, hostile}};
  findings.notes = {hostile};
  auto& table = std::get<ResultTable>(findings.sections[0]);
  table.title = table.caption = table.rowsAre = table.columns[0].name = table.rows[0].name = hostile;
  auto& chart = std::get<LineChart>(findings.sections[1]);
  chart.title = chart.caption = chart.xName = chart.yName = chart.lines[0].name = hostile;
  auto& bars = std::get<StackedBars>(findings.sections[2]);
  bars.title = bars.caption = bars.parts[0] = bars.bars[0].name = hostile;
  auto& matrix = std::get<HeatTable>(findings.sections[3]);
  matrix.title = matrix.caption = matrix.names[0] = hostile;
  const std::string html = renderFindingsPage(findings);
  EXPECT_EQ(count(html, "<script"), 1U);
  EXPECT_EQ(Html(html).count("img"), 0U);
  EXPECT_EQ(count(html, "\xFF"), 0U);
  EXPECT_FALSE(std::regex_search(html, std::regex("https?:|@import|url\\(|<link|<iframe")));
}

TEST(FindingsPage, IsWrittenWholeOrNotAtAll) {
  const test::ScratchFolder scratch;
  writeFindingsPage(scratch / "report.html", samplePage());
  EXPECT_EQ(test::readFile(scratch / "report.html"), renderFindingsPage(samplePage()));
  EXPECT_THROW(writeFindingsPage(scratch / "missing" / "report.html", samplePage()), Error);
}

/// The heights of a chart's curve, from 0 at the top to 280 at the foot.
std::vector<double> heights(const LineChart& chart) {
  const std::string svg = section(chart).str();
  std::smatch path;
  const std::string plot = svg.substr(svg.find("class=\"plot\""));
  std::regex_search(plot, path, std::regex("<path class=\"curve[^>]* d=\"([^\"]*)\""));
  const std::string d = path[1];
  std::vector<double> found;
  const std::regex point("[ML]([-0-9.]+)[ ,]([-0-9.]+)");
  for (std::sregex_iterator it(d.begin(), d.end(), point), end; it != end; ++it)
    found.push_back(std::stod((*it)[2]));
  return found;
}

TEST(LineChart, DrawsValuesInProportion) {
  LineChart chart{"", "", "", "", false, {1, 2, 3}, {{"a", {100, 50, 0}}}};
  const auto y = heights(chart);
  ASSERT_EQ(y.size(), 3U);
  EXPECT_DOUBLE_EQ(y[2], 280);
  EXPECT_NEAR(280 - y[0], 2 * (280 - y[1]), 0.2);
}

TEST(LineChart, DrawsRatiosInProportionOnALogarithmicAxis) {
  LineChart chart{"", "", "", "", true, {1, 2, 3, 4}, {{"a", {100, 10, 1, 0}}}};
  const auto y = heights(chart);
  ASSERT_EQ(y.size(), 4U);
  EXPECT_NEAR(y[1] - y[0], y[2] - y[1], 0.2);
  EXPECT_GT(y[1] - y[0], 100);
  EXPECT_DOUBLE_EQ(y[3], 280) << "0 lies at the foot";
}

TEST(LineChart, OfNothingOnePointOrEqualValuesIsADrawing) {
  for (const auto& [x, y] : std::vector<std::pair<std::vector<double>, std::vector<double>>>{
           {{}, {}}, {{5}, {0}}, {{5}, {2}}, {{1, 2}, {3, 3}}, {{1, 2}, {0, 0}}, {{1, 2}, {3}}})
    for (const bool closeUp : {false, true}) {
      const std::string svg = section(LineChart{"", "", "", "", false, x, {{"a", y}}, closeUp}).str();
      EXPECT_EQ(count(svg, "nan") + count(svg, "inf"), 0U) << svg;
      EXPECT_EQ(count(svg, "class=\"plot\""), 1U);
    }
}

TEST(LineChart, BreaksWhereNothingIsKnown) {
  LineChart chart{"", "", "", "", false, {1, 2, 3, 4, 5}, {{"a", {1, 2, NAN, 3, 4}}}};
  const std::string svg = section(chart).str();
  const std::string plot = svg.substr(svg.find("class=\"plot\""));
  const std::string curve = plot.substr(plot.find("class=\"curve"));
  EXPECT_EQ(count(curve.substr(0, curve.find('>')), "M"), 2U);
}

TEST(LineChartFigure, PointsOutAMarkThatIsOneOfItsPositions) {
  LineChart chart{"Curves", "", "k", "V", false, {1, 2, 3}, {{"a", {0.1, 0.2, NAN}, 2.0}}};
  EXPECT_EQ(count(section(chart).str(), "class=\"mark c0\""), 1U);
  for (const double elsewhere : {3.0, 7.0}) {
    chart.lines[0].mark = elsewhere;
    EXPECT_EQ(count(section(chart).str(), "class=\"mark"), 0U) << elsewhere;
  }
}

TEST(FindingsFiles, AreAPageATableAndADiagram) {
  const test::ScratchFolder scratch;
  Findings findings;
  findings.title = "Which | one?";
  findings.summary = "That one.";
  findings.facts = {{"Tests", "7"}};
  findings.notes = {"one was left out"};
  findings.sections.emplace_back(RankDiagram{"Ranks", "", {{"a", 1.25}, {"b", 1.75}}, {{0, 1}}, {}, 0});
  findings.sections.emplace_back(ResultTable{
      "Table", "Less is better.", "method", {{"rank", 2}}, {{"a", {1.25}}, {"b", {std::nullopt}}}});
  writeFindingsFiles(scratch / "v1.2", findings);
  EXPECT_EQ(readFile(scratch / "v1.2.md"),
            "# Which \\| one?\n\nThat one.\n\n* Tests: 7\n\n| method | rank |\n| --- | ---: |\n| a | 1.25 |\n"
            "| b | – |\n\nLess is better.\n\none was left out\n");
  EXPECT_EQ(readFile(scratch / "v1.2.csv"), "method,rank\na,1.25\nb,\n");
  EXPECT_EQ(readFile(scratch / "v1.2.tex"), latexTable(std::get<ResultTable>(findings.sections[1])));
  EXPECT_EQ(readFile(scratch / "v1.2.svg"), renderRankDiagram(std::get<RankDiagram>(findings.sections[0])));
  EXPECT_EQ(readFile(scratch / "v1.2.html"), renderFindingsPage(findings));
}

TEST(FindingsFiles, OfWhatIsNotThereAreNotWritten) {
  const test::ScratchFolder scratch;
  Findings findings;
  findings.title = "Nothing";
  writeFindingsFiles(scratch / "empty", findings);
  EXPECT_TRUE(std::filesystem::exists(scratch / "empty.html"));
  for (const char* ending : {".md", ".csv", ".tex", ".svg"})
    EXPECT_FALSE(std::filesystem::exists(scratch / (std::string("empty") + ending))) << ending;
  EXPECT_THAT([&] { writeFindingsFiles(scratch / "nowhere/empty", findings); },
              FailsWith(ErrorCode::fileUnwritable, "nowhere"));
}

}  // namespace
}  // namespace estancia
