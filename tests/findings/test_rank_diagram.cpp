// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "estancia/figures/svg.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/findings/findings_page.hpp"
#include "support/html_checks.hpp"

namespace estancia {
namespace {

using report::Box;
using test::count;
using test::Html;

/// Methods with names of this length, their ranks spread evenly or all alike.
RankDiagram sampleDiagram(std::size_t methods, std::size_t length, bool equal = false) {
  RankDiagram diagram{"Ranks", "Best at the left.", {}, {}, 1.25, 0};
  for (std::size_t m = 0; m < methods; ++m) {
    std::string name = "method " + std::to_string(m) + " ";
    while (name.size() < length) name += "long ";
    const double mean = (1 + static_cast<double>(methods)) / 2;
    diagram.methods.push_back({name + std::to_string(m), equal ? mean : 1 + static_cast<double>(m)});
    if (m + 2 < methods) diagram.groups.emplace_back(m, m + 2);
  }
  return diagram;
}

double attribute(const std::string& tag, const std::string& name) {
  std::smatch found;
  std::regex_search(tag, found, std::regex(" " + name + "=\"([-0-9.]+)\""));
  return std::stod(found[1]);
}

/// Boxes of all texts of the drawing, in Helvetica.
std::vector<Box> texts(const std::string& svg) {
  std::vector<Box> boxes;
  const std::regex element("<text class=\"([a-z ]+)\"([^>]*)>([^<]*)<");
  for (std::sregex_iterator it(svg.begin(), svg.end(), element), end; it != end; ++it) {
    const std::string tag = (*it)[2];
    const double size = (*it)[1] == "rank" ? 12 : 14, width = size * report::textWidth((*it)[3].str());
    const double x = attribute(tag, "x"), y = attribute(tag, "y");
    const bool end1 = tag.find("\"end\"") != std::string::npos,
               middle = tag.find("\"middle\"") != std::string::npos;
    boxes.push_back({x - (end1 ? width : middle ? width / 2 : 0), y - 0.75 * size, width, 0.95 * size});
  }
  return boxes;
}

/// The corners of all paths of a class.
std::vector<std::vector<report::Point>> paths(const std::string& svg, const std::string& className) {
  std::vector<std::vector<report::Point>> found;
  const std::regex element("<path class=\"" + className + "[^\"]*\" d=\"([^\"]*)\"");
  const std::regex point("[ML]([-0-9.]+) ([-0-9.]+)");
  for (std::sregex_iterator it(svg.begin(), svg.end(), element), end; it != end; ++it) {
    const std::string d = (*it)[1];
    found.emplace_back();
    for (std::sregex_iterator p(d.begin(), d.end(), point); p != end; ++p)
      found.back().push_back({std::stod((*p)[1]), std::stod((*p)[2])});
  }
  return found;
}

class RankDiagramSizes : public testing::TestWithParam<std::tuple<std::size_t, std::size_t, bool>> {};

TEST_P(RankDiagramSizes, NothingOverlaps) {
  const auto [methods, length, equal] = GetParam();
  const std::string svg = renderRankDiagram(sampleDiagram(methods, length, equal));
  const Box page{0, 0, attribute(svg, "width"), attribute(svg, "height")};
  const std::vector<Box> boxes = texts(svg);
  EXPECT_GE(boxes.size(), 2 * methods + 1);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_TRUE(boxes[i].inside(page)) << i;
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(boxes[i].overlaps(boxes[j])) << i << " " << j;
  }
  const auto stems = paths(svg, "stem");
  EXPECT_EQ(stems.size(), methods);
  for (const auto& stem : stems) {
    ASSERT_EQ(stem.size(), 3U) << "down from the axis, then across";
    EXPECT_EQ(stem[0].x, stem[1].x);
    EXPECT_EQ(stem[1].y, stem[2].y);
    for (const Box& box : boxes) {
      EXPECT_FALSE(box.crosses(stem[0], stem[1]));
      EXPECT_FALSE(box.crosses(stem[1], stem[2]));
    }
    for (const auto& other : stems)  // no stem runs across another's way down
      if (!equal && other[0].x != stem[0].x) {
        const bool passes = (stem[1].x - other[0].x) * (stem[2].x - other[0].x) < 0;
        EXPECT_FALSE(passes && other[1].y > stem[1].y);
      }
  }
  const auto bars = paths(svg, "group");
  for (std::size_t i = 0; i < bars.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_FALSE(bars[i][0].y == bars[j][0].y && bars[i][0].x < bars[j][1].x &&
                   bars[j][0].x < bars[i][1].x);
}

INSTANTIATE_TEST_SUITE_P(All, RankDiagramSizes,
                         testing::Combine(testing::Values(1, 2, 3, 12, 40, 150), testing::Values(1, 20, 90),
                                          testing::Bool()));

TEST(RankDiagram, PlacesRanksInProportion) {
  RankDiagram diagram{"",       "",           {{"a", 1}, {"b", 2.5}, {"c", 2.5}, {"d", 4}},
                      {{1, 2}}, std::nullopt, std::nullopt};
  const auto stems = paths(renderRankDiagram(diagram), "stem");
  ASSERT_EQ(stems.size(), 4U);
  EXPECT_NEAR(stems[1][0].x - stems[0][0].x, stems[3][0].x - stems[2][0].x, 0.2);
  EXPECT_EQ(stems[1][0].x, stems[2][0].x);
  EXPECT_LT(stems[1][2].x, stems[1][0].x) << "the better half is named at the left";
  EXPECT_GT(stems[2][2].x, stems[2][0].x);
}

TEST(RankDiagram, DrawsTheCriticalDifferenceToScale) {
  RankDiagram diagram = sampleDiagram(5, 1);
  diagram.criticalDifference = 2;
  const std::string svg = renderRankDiagram(diagram);
  const auto stems = paths(svg, "stem");
  const auto lines = paths(svg, "line");
  EXPECT_NEAR(lines.back()[3].x - lines.back()[2].x, stems[2][0].x - stems[0][0].x, 0.2);
  EXPECT_THAT(Html(svg).texts("text"), testing::Contains("critical difference 2.00"));
  diagram.criticalDifference.reset();
  EXPECT_FALSE(Html(renderRankDiagram(diagram)).mentions("critical"));
}

TEST(RankDiagram, KeepsBothEndsOfLongNames) {
  RankDiagram diagram = sampleDiagram(2, 1);
  diagram.methods[0].name = "inception-v3+places365+resnet50+gist+esf+phog+more+of+them/svm-rbf";
  const std::string svg = renderRankDiagram(diagram);
  EXPECT_TRUE(std::regex_search(svg, std::regex(">inception-v3[^<]*…[^<]*/svm-rbf<")));
  EXPECT_TRUE(Html(svg).texts("title")[0].starts_with(diagram.methods[0].name))
      << "the whole name when pointed at";
  for (const auto& [method, part] : {std::pair{0, "esf"}, {1, "gist"}})
    diagram.methods[static_cast<std::size_t>(method)].name =
        "inception-v3+places365+resnet50+" + std::string(part) + "+more+of+them+of+all+kinds/svm-rbf";
  const std::string apart = renderRankDiagram(diagram);
  for (const char* part : {">…esf…<", ">…gist…<"}) EXPECT_EQ(count(apart, part), 1U) << part;
}

TEST(RankDiagram, IsPartOfThePageAndAFileOfItsOwn) {
  Findings findings;
  findings.title = "Which?";
  findings.sections.emplace_back(sampleDiagram(12, 20));
  const std::string html = renderFindingsPage(findings);
  test::expectWellFormed(html);
  test::expectNothingFromOutside(html);
  EXPECT_EQ(count(html, "class=\"stem"), 12U);
  EXPECT_THAT(Html(html).texts("figcaption"), testing::ElementsAre("Best at the left."));
  const std::string svg = renderRankDiagram(sampleDiagram(12, 20));
  EXPECT_TRUE(svg.starts_with("<?xml"));
  EXPECT_EQ(count(svg, "prefers-color-scheme:dark"), 1U);
  EXPECT_EQ(count(svg, "name control"), 1U);
}

TEST(RankDiagram, SurvivesAnyNameAndNone) {
  RankDiagram diagram = sampleDiagram(3, 1);
  diagram.title = diagram.caption = diagram.methods[0].name = test::hostileText;
  Findings findings;
  findings.sections.emplace_back(diagram);
  findings.sections.emplace_back(RankDiagram{});
  const std::string html = renderFindingsPage(findings);
  test::expectWellFormed(html);
  test::expectNothingFromOutside(html);
  for (const std::string& text :
       {html, renderRankDiagram(RankDiagram{}), renderRankDiagram(sampleDiagram(1, 1))}) {
    EXPECT_FALSE(Html(text).mentions("nan"));
    EXPECT_FALSE(Html(text).mentions("inf"));
  }
}

}  // namespace
}  // namespace estancia
