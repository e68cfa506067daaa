// SPDX-License-Identifier: Apache-2.0
#include "places/room_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "zones/room_classes.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using testing::ElementsAre;

std::vector<Frame> named(const std::vector<std::string>& names) {
  std::vector<Frame> frames;
  for (const std::string& name : names) frames.push_back({name, {}, {}, ""});
  return frames;
}

TEST(RoomTable, MatchesImagesByNameOrNumber) {
  const test::ScratchFolder scratch;
  test::writeFile(scratch / "rooms.csv", "n,room\n7,kitchen\n0,hall\nhall.png,\"a, b\"\n99,nowhere\n");
  const RoomTable table(scratch / "rooms.csv", "n", named({"0000.jpg", "0007.jpg", "0008.jpg", "hall.jpg"}));
  EXPECT_THAT(table.column("room"), ElementsAre("hall", "kitchen", "", "a, b"));
  EXPECT_THAT(table.column("n"), ElementsAre("0", "7", "", "hall.png"));
}

TEST(RoomTable, SaysWhatIsWrongAndWhere) {
  const test::ScratchFolder scratch;
  const std::string file = scratch / "rooms.csv";
  const auto problem = [&](const std::string& text, const std::string& column) {
    test::writeFile(file, text);
    return test::caught([&] { RoomTable(file, "n", named({"1.png"})).column(column); });
  };
  EXPECT_THAT([&] { RoomTable(scratch / "none.csv", "n", {}); },
              FailsWith(ErrorCode::fileNotFound, "none.csv"));
  EXPECT_THAT(problem("", "room"), FailsWith(ErrorCode::insufficientData, "rooms.csv"));
  EXPECT_THAT(problem("image,room\n", "room"), FailsWith(ErrorCode::malformedFile, "rooms.csv:1", "\"n\""));
  EXPECT_THAT(problem("n,room\n1,hall\n", "place"),
              FailsWith(ErrorCode::malformedFile, "rooms.csv:1", "\"place\""));
  EXPECT_THAT(problem("n,room\n1,hall\n\n2\n", "room"), FailsWith(ErrorCode::malformedFile, "rooms.csv:4"));
}

TEST(RoomClasses, AreRunsOfOneRoomInARow) {
  const std::vector<std::string> rooms{"hall", "hall", "lab", "", "hall", "hall"};
  EXPECT_THAT(classesOfRuns(named({"a", "b", "c", "d", "e", "f"}), rooms, {}, 1),
              ElementsAre("hall 1", "hall 1", "lab 1", "", "hall 2", "hall 2"));
}

TEST(RoomClasses, BeginAnewWhereMarksChangeOrNumbersAreLeftOut) {
  const std::vector<std::string> rooms(6, "hall");
  EXPECT_THAT(classesOfRuns(named({"1.png", "2.png", "4.png", "5.png", "6.png", "7.png"}), rooms,
                            {"a", "a", "a", "a", "b", "b"}, 1),
              ElementsAre("hall 1", "hall 1", "hall 2", "hall 2", "hall 3", "hall 3"));
}

TEST(RoomClasses, OfEveryThirdImageAreThoseOfAll) {
  EXPECT_THAT(classesOfRuns(named({"00.png", "03.png", "06.png", "09.png", "12.png", "15.png"}),
                            {"hall", "hall", "hall", "lab", "lab", "lab"}, {}, 1),
              ElementsAre("hall 1", "hall 1", "hall 1", "lab 1", "lab 1", "lab 1"));
}

TEST(RoomClasses, CutsRunsIntoEqualParts) {
  const std::vector<std::string> rooms{"hall", "hall", "hall", "hall", "hall", "lab"};
  EXPECT_THAT(classesOfRuns(named({"a", "b", "c", "d", "e", "f"}), rooms, {}, 2),
              ElementsAre("hall 1", "hall 1", "hall 1", "hall 2", "hall 2", "lab 1"));
  EXPECT_THAT(classesOfRuns(named({"a", "b"}), {"hall", "hall"}, {}, 7), ElementsAre("hall 1", "hall 2"));
  EXPECT_TRUE(classesOfRuns({}, {}, {}, 2).empty());
}

}  // namespace
}  // namespace estancia::experiments
