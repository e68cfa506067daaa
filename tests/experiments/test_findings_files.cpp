#include "experiments/src/findings/findings_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "estancia/core/error.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::errorOf;
using test::readFile;
using testing::HasSubstr;

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
  const std::string markdown = readFile(scratch / "v1.2.md");
  for (const char* text :
       {"# Which \\| one?\n", "That one.", "* Tests: 7", "| 1.25 |", "Less is better", "one was left out"})
    EXPECT_THAT(markdown, HasSubstr(text));
  EXPECT_EQ(readFile(scratch / "v1.2.csv"), "method,rank\na,1.25\nb,\n");
  EXPECT_THAT(readFile(scratch / "v1.2.tex"), HasSubstr("\\begin{tabular}"));
  EXPECT_THAT(readFile(scratch / "v1.2.svg"), HasSubstr("<svg"));
  EXPECT_THAT(readFile(scratch / "v1.2.html"), HasSubstr("That one."));
}

TEST(FindingsFiles, OfWhatIsNotThereAreNotWritten) {
  const test::ScratchFolder scratch;
  Findings findings;
  findings.title = "Nothing";
  writeFindingsFiles(scratch / "empty", findings);
  EXPECT_TRUE(std::filesystem::exists(scratch / "empty.html"));
  for (const char* ending : {".md", ".csv", ".tex", ".svg"})
    EXPECT_FALSE(std::filesystem::exists(scratch / (std::string("empty") + ending))) << ending;
  EXPECT_THAT(errorOf([&] { writeFindingsFiles(scratch / "nowhere/empty", findings); }),
              HasSubstr("nowhere"));
}

}  // namespace
}  // namespace estancia::experiments
