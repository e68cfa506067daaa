// Numbers that others computed, and all that can be wrong with a CSV of them.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/io/feature_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<std::string> kObjects = {"Extinguisher", "Chair", "Printer", "Bookshelf",
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
  EXPECT_THAT(table.groups, IsEmpty());
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
  const FeatureTable training = readFeatureTable(*data / "training.csv", {kObjects});
  const FeatureTable test = readFeatureTable(*data / "test.csv", {kObjects});
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
