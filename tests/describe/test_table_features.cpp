// Tables of others' numbers as features.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/describe/table_features.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using ::testing::ElementsAre;

Features featuresOfText(const std::string& text) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "f.csv", text);
  return featuresOf(readFeatureTable(folder / "f.csv"));
}

PartKind kindOf(const std::string& first, const std::string& second) {
  return featuresOfText("room,h0,h1,h2\nhall," + first + "\noffice," + second + "\n").parts.at(0).kind;
}

TEST(TableFeatures, ConstantSumsAreHistograms) {
  EXPECT_EQ(kindOf("0.5,0.25,0.25", "0,0,1"), PartKind::histogram);
  EXPECT_EQ(kindOf("50,25,25", "0,99.99,0"), PartKind::histogram) << "rounding is no difference";
  EXPECT_EQ(kindOf("0,0,0", "0,0,1"), PartKind::histogram) << "nothing was counted";
  EXPECT_EQ(kindOf("0.5,0.25,0.25", "0,0.5,0"), PartKind::energies);
  EXPECT_EQ(kindOf("-0.5,1.25,0.25", "0,0,1"), PartKind::energies);
  EXPECT_EQ(kindOf("0,0,0", "0,0,0"), PartKind::energies);
  EXPECT_EQ(kindOf("1,2,3", "1,2,3"), PartKind::energies) << "constants may be below 0 elsewhere";
}

TEST(TableFeatures, ASingleColumnIsNoHistogram) {
  const Features features = featuresOfText("room,height,h0,h1\nhall,1,0.5,0.5\noffice,1,0,1\n");
  ASSERT_EQ(features.parts.size(), 2U);
  EXPECT_EQ(features.parts[0].kind, PartKind::energies);
  EXPECT_EQ(features.parts[1].kind, PartKind::histogram);
  EXPECT_THAT(features.parts[1].columns, ElementsAre("h0", "h1"));
  EXPECT_EQ(features.frames[1].room, "office");
  EXPECT_THAT(features.values.row(1), ElementsAre(1, 0, 1));
}

TEST(TableFeatures, TablesOfTheSameColumnsFitEachOther) {
  const auto parts = featuresOfText("room,h0,h1\nhall,1,0\n").parts;
  EXPECT_EQ(featuresOfText("image,h0,h1,room\na,0.5,0.5,office\n").parts, parts);
  EXPECT_NE(featuresOfText("room,h0,h1,h2\nhall,1,0,0\n").parts[0].identity, parts[0].identity);
}

TEST(RealTableFeatures, RobotVisionGivesTwoHistograms) {
  const auto data = test::findData("robotvision2014_feat");
  ESTANCIA_NEEDS(data, "the real data set robotvision2014_feat is missing");
  const FeatureTableOptions options{
      {"Extinguisher", "Chair", "Printer", "Bookshelf", "Urinal", "Trash", "Phone", "Fridge"}};
  const Features training = featuresOf(readFeatureTable(*data / "training.csv", options));
  ASSERT_EQ(training.parts.size(), 2U);
  for (const DescriptorPart& part : training.parts) EXPECT_EQ(part.kind, PartKind::histogram) << part.name;
  EXPECT_EQ(featuresOf(readFeatureTable(*data / "test.csv", options)).parts, training.parts);
}

TEST(TableFeatures, ColumnsOfZeroAndOneAreBinary) {
  const Features features = featuresOfText("room,Chair,g0,g1,Desk,size\nhall,1,1,0,0,1\nlab,0,0,1,0,2\n");
  EXPECT_THAT(binaryParts(features), ElementsAre("Chair", "Desk")) << "g has two columns, size a 2";
}

TEST(TableFeatures, AreSelectedByRoomAndCountedByRoom) {
  const Features features = featuresOfText("room,g0,g1\nhall,1,0\nlab,0,1\nhall,3,0\n");
  EXPECT_EQ(framesPerRoom(features), (std::map<std::string, std::size_t>{{"hall", 2}, {"lab", 1}}));
  const Features hall = withRooms(features, {"hall"});
  ASSERT_EQ(hall.frames.size(), 2U);
  EXPECT_THAT(hall.values.row(1), ElementsAre(3, 0));
  EXPECT_EQ(withRooms(features, {}).frames.size(), 3U);
  EXPECT_THAT(
      [&] {
        withRooms(features, {"lab", "garage"});
      },
      test::FailsWith(ErrorCode::unknownName, "garage", "hall", "lab"));
}

}  // namespace
}  // namespace estancia
