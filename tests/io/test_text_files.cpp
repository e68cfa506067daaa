// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "estancia/io/csv.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/text_file.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::io {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

TEST(TextFile, HasNoControlCharactersButLineEndsTabsAndFormFeeds) {
  const test::ScratchFolder folder;
  const auto isText = [&](const std::string& content) {
    test::writeFile(folder / "file", content);
    return isTextFile(folder / "file");
  };
  EXPECT_TRUE(isText("a,\tb\r\n\fcafé\n"));
  for (const char c : {'\0', '\1', '\x1b'}) EXPECT_FALSE(isText(std::string("GIF89a") + c));
  EXPECT_FALSE(isText(""));
  EXPECT_FALSE(isTextFile(folder.path()));
}

TEST(NaturalOrder, ComparesRunsOfDigitsAsNumbers) {
  std::vector<std::string> names = {"img10", "img9", "img010b", "img1",
                                    "b2",    "img",  "img01",   "a9999999999999999999999"};
  std::ranges::sort(names, naturalLess);
  EXPECT_THAT(names, ElementsAre("a9999999999999999999999", "b2", "img", "img01", "img1", "img9", "img10",
                                 "img010b"));
}

TEST(Printable, KeepsUtf8AndShowsWhatNoTerminalShould) {
  EXPECT_EQ(printable("habitación 1 🏠"), "habitación 1 🏠");
  EXPECT_EQ(printable("two\nlines\x1B[2J"), "two\\x0Alines\\x1B[2J");
  EXPECT_EQ(printable("latin \xE9"), "latin \\xE9");
  EXPECT_EQ(printable("\xC0\xAF \xED\xA0\x80 \xF4\x90\x80\x80"),
            "\\xC0\\xAF \\xED\\xA0\\x80 \\xF4\\x90\\x80\\x80");
  EXPECT_EQ(printable("\u009B2J"), "\\xC2\\x9B2J") << "the C1 control CSI";
  EXPECT_EQ(printable("\u202Egpj.exe\u2066 \u2028"), "\\xE2\\x80\\xAEgpj.exe\\xE2\\x81\\xA6 \\xE2\\x80\\xA8");
  EXPECT_EQ(printable("\u00A0\u00E9\u200D\u2030\u2065\u206A"), "\u00A0\u00E9\u200D\u2030\u2065\u206A");
}

TEST(Numbers, MustBeWholeWords) {
  EXPECT_EQ(toNumber("-1.5e-3"), -1.5e-3);
  EXPECT_EQ(toNumber("+2"), 2);
  EXPECT_TRUE(std::isnan(toNumber("nan").value()));
  for (const char* wrong : {"", "1,5", "1.5x", " 1", "x"}) EXPECT_EQ(toNumber(wrong), std::nullopt) << wrong;
}

class Csv : public ::testing::Test {
 protected:
  std::vector<CsvRow> read(const std::string& text) {
    test::writeFile(folder_ / "a.csv", text);
    return readCsv(folder_ / "a.csv");
  }
  test::ScratchFolder folder_;
};

TEST_F(Csv, TakesQuotesCommasAndLineEndsInsideCells) {
  const auto rows = read("\xEF\xBB\xBFimage, room\r\n\r\n\"a, \"\"b\"\".jpg\" ,\"two\nlines\"\n x ,\n");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_THAT(rows[0].cells, ElementsAre("image", "room"));
  EXPECT_THAT(rows[1].cells, ElementsAre("a, \"b\".jpg", "two\nlines"));
  EXPECT_EQ(rows[1].line, 3U);
  EXPECT_THAT(rows[2].cells, ElementsAre("x", ""));
  EXPECT_EQ(rows[2].line, 5U);
}

TEST_F(Csv, NamesTheLineOfAnOpenQuote) {
  EXPECT_THAT([&] { read("a,b\n\"c,d\ne,f\n"); }, FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia::io
