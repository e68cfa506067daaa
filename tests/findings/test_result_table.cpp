// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/result_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/files/csv.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

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
