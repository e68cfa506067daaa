// What pages of documentation are written from: tables as Markdown, and where they were measured.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "runner/run_files.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

Findings someFindings() {
  Findings findings;
  findings.title = "Trials";
  findings.summary = "Two_of three.";
  findings.sections.emplace_back(
      ResultTable{"First [m]", "As measured.", "trial", {{"length", 1}}, {{"a|b", {1.25}}, {"c", {{}}}}});
  findings.sections.emplace_back(LineChart{});
  findings.sections.emplace_back(HeatTable{"Pairs", "", {"x", "y"}, {0, 0.5, NAN, 0}});
  return findings;
}

TEST(RunFiles, HaveTheSummaryAndEachTableUnderItsTitle) {
  EXPECT_EQ(findingsMarkdown(someFindings()),
            "# Trials\n\nTwo\\_of three.\n\n## First \\[m\\]\n\nAs measured.\n\n"
            "| trial | length |\n| --- | ---: |\n| a\\|b | 1.2 |\n| c | – |\n\n## Pairs\n\n"
            "|  | x | y |\n| --- | ---: | ---: |\n| x | 0.00 | 0.50 |\n| y | – | 0.00 |\n");
}

TEST(RunFiles, NameTheProcessor) {
  EXPECT_EQ(processorName("processor\t: 0\nmodel name\t: Old 7\nmodel name\t: New 8\n"), "Old 7");
  EXPECT_EQ(processorName("model name"), "");
  EXPECT_EQ(processorName("Hardware\t: board\n"), "");
}

TEST(RunFiles, SayWhenWhereAndOfWhat) {
  const test::ScratchFolder scratch;
  ExperimentRun run;
  run.folder = scratch / "";
  run.models = {"small"};
  writeRunFiles(run, {"one.toml", "two.toml"}, someFindings(), 12.4);
  EXPECT_EQ(test::readFile(scratch / "findings.md"), findingsMarkdown(someFindings()));
  const auto json = nlohmann::json::parse(test::readFile(scratch / "run.json"));
  EXPECT_EQ(json["configurations"], nlohmann::json({"one.toml", "two.toml"}));
  EXPECT_EQ(json["models"], nlohmann::json({"small"}));
  EXPECT_EQ(json["seconds"], 12);
  EXPECT_GE(json["cores"], 1);
  EXPECT_THAT(json["date"], testing::MatchesRegex("20..-..-..T..:..:..Z"));
}

}  // namespace
}  // namespace estancia::experiments
