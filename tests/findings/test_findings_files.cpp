// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/findings_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "estancia/core/error.hpp"
#include "estancia/findings/result_table.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::readFile;

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
