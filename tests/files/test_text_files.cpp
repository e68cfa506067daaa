// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/feature_table.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"

namespace estancia {
namespace {

using io::isTextFile;
using io::toNumber;
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
  std::ranges::sort(names, io::naturalLess);
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
  std::vector<io::CsvRow> read(const std::string& text) {
    test::writeFile(folder_ / "a.csv", text);
    return io::readCsv(folder_ / "a.csv");
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

const std::vector<std::string> objects = {"Extinguisher", "Chair", "Printer", "Bookshelf",
                                          "Urinal",       "Trash", "Phone",   "Fridge"};

class FeatureTables : public ::testing::Test {
 protected:
  FeatureTable read(const std::string& text, std::vector<std::string> ignored = {}) {
    test::writeFile(folder_ / "f.csv", text);
    return readFeatureTable(folder_ / "f.csv", {std::move(ignored)});
  }
  test::Caught refusal(const std::string& text, std::vector<std::string> ignored = {}) {
    return test::caught([&] { read(text, std::move(ignored)); });
  }
  test::ScratchFolder folder_;
};

TEST_F(FeatureTables, RunningNumbersAreOnePart) {
  const FeatureTable table = read(
      "image,g0,g1,g2,room,weight,d7,d8,group,e5,9\na.png,1,2,3,hall,-4,5,6e1,monday,7,8\n"
      "b.png,0,0,.5,\"the \"\"office\"\"\",0,0,0,,0,0\n");
  EXPECT_THAT(table.parts,
              ElementsAre(FeaturePart{"g", 0, 3}, FeaturePart{"weight", 3, 1}, FeaturePart{"d", 4, 2},
                          FeaturePart{"e5", 6, 1}, FeaturePart{"9", 7, 1}));
  EXPECT_THAT(table.columns, ElementsAre("g0", "g1", "g2", "weight", "d7", "d8", "e5", "9"));
  ASSERT_EQ(table.values.size(), 2U);
  EXPECT_THAT(table.values.row(0), ElementsAre(1, 2, 3, -4, 5, 60, 7, 8));
  EXPECT_EQ(table.values.row(1)[2], 0.5F);
  EXPECT_EQ(table.frames[0].name, "a.png");
  EXPECT_EQ(table.frames[1].room, "the \"office\"");
  EXPECT_THAT(table.groups, ElementsAre("monday", ""));
}

TEST_F(FeatureTables, ClassIsAnotherNameOfRoomAndLinesOfFrames) {
  const FeatureTable table = read(
      "\xEF\xBB\xBF"
      "class,f1,f2\r\nhall,1,2\r\n\r\n,3,4\r\n");
  EXPECT_EQ(table.frames[0].room, "hall");
  EXPECT_EQ(table.frames[1].room, "");
  EXPECT_EQ(table.frames[1].name, "line 4");
  EXPECT_THAT(table.groups, testing::IsEmpty());
}

TEST_F(FeatureTables, IgnoredColumnsMayHoldAnything) {
  const FeatureTable table = read("room,note,class,f\nhall,it is nice,nan,1\n", {"note", "class"});
  EXPECT_THAT(table.columns, ElementsAre("f"));
}

// The texts of this room: where the value stands, and what it is.
TEST_F(FeatureTables, NamesTheCellThatIsNoNumber) {
  const std::string header = "room,f0,f1\nhall,1,2\n";
  EXPECT_THAT(refusal(header + "hall,1,nan\n"),
              FailsWith(ErrorCode::malformedFile, "f.csv:3:3", "\"nan\"", "f1"));
  EXPECT_THAT(refusal("room,note,f\nhall,nice,1\n"),
              FailsWith(ErrorCode::malformedFile, "f.csv:2:2", "\"nice\"", "note"));
}

TEST_F(FeatureTables, RefusesTablesThatContradictThemselves) {
  for (const std::string& text :
       {std::string("room,f0,f1\nhall,1\n"), std::string("room,f0,f1\nhall,1,2,3\n"),
        std::string("room,f0\nhall,1\nroom,f0\nhall,2\n"), std::string("room,f0,f0\nhall,1,2\n"),
        std::string("room,,f0\nhall,1,2\n"), std::string("f0,f1\n1,2\n"),
        std::string("room,class,f\nhall,1,2\n"), std::string("room,image\nhall,a\n"),
        std::string("room,f0,f1,g,f3,f4\nhall,1,2,3,4,5\n"),
        std::string("image,room,f\na,hall,1\na,hall,2\n"), std::string("room,f\n\"hall,1\n"),
        std::string("room,f\nha\0ll,1\n", 14), std::string("room,f\nhall,-inf\n"),
        std::string("room,f\nhall,1e300\n"), std::string("room,f\nhall,\n")})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::malformedFile)) << text;
  for (const char* text : {"", "room,f\n"})
    EXPECT_THAT(refusal(text), FailsWith(ErrorCode::insufficientData)) << text;
  EXPECT_THAT(refusal("room,f\nhall,1\n", {"chair"}), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { readFeatureTable(folder_ / "none.csv"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST(RealFeatureTable, IsThatOfRobotVision) {
  const auto data = test::findData("robotvision2014_feat");
  ESTANCIA_NEEDS(data, "the real data set robotvision2014_feat is missing");
  const FeatureTable training = readFeatureTable(*data / "training.csv", {objects});
  const FeatureTable test = readFeatureTable(*data / "test.csv", {objects});
  EXPECT_EQ(training.frames.size(), 4500U);
  EXPECT_EQ(test.frames.size(), 500U);
  EXPECT_THAT(training.parts, ElementsAre(FeaturePart{"g", 0, 256}, FeaturePart{"d", 256, 8}));
  EXPECT_EQ(training.parts, test.parts);
  EXPECT_EQ(training.columns, test.columns);
  EXPECT_EQ(std::ranges::count(test.frames, "Corridor", &Frame::room) +
                std::ranges::count(training.frames, "Corridor", &Frame::room),
            1833);
  EXPECT_THAT(readFeatureTable(*data / "test.csv").parts, ::testing::SizeIs(10)) << "the objects, too";
}

TEST_F(FeatureTables, AreRecognizedByTheirColumnOfRooms) {
  const auto isTable = [&](const std::string& name, const std::string& text) {
    test::writeFile(folder_ / name, text);
    return isFeatureTable(folder_ / name);
  };
  EXPECT_TRUE(isTable("a.csv", "image,room,g0\na,hall,1\n"));
  EXPECT_TRUE(isTable("b.csv", "g0, \"class\"\r\n1,hall\r\n"));
  EXPECT_FALSE(isTable("c.csv", "image,stove,bathroom\na,0.1,0.9\n"));
  EXPECT_FALSE(isTable("d.csv", ""));
  EXPECT_FALSE(isTable("e.labels", "image,room,g0\n"));
  EXPECT_FALSE(isFeatureTable(folder_ / "missing.csv"));
}

}  // namespace
}  // namespace estancia
