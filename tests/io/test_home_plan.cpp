// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/io/home_plan.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::io {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

/// A hall that is L-shaped around a bath, which lies in its upper right corner.
constexpr const char* kHall =
    R"({"name": "hall", "polygon": [[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]]})";
constexpr const char* kBath = R"({"name": "bath", "polygon": [[2, 2], [4, 2], [4, 4], [2, 4]]})";

class HomePlans : public ::testing::Test {
 protected:
  HomePlan read(const std::string& text) {
    test::writeFile(folder_ / "home.json", text);
    return readHomePlan(folder_ / "home.json");
  }
  auto reading(const std::string& text) {
    return [this, text] { read(text); };
  }
  HomePlan readTwoRooms(const std::string& openings) {
    return read(std::string(R"({"rooms": [)") + kHall + "," + kBath + "]" + openings + "}");
  }
  test::ScratchFolder folder_;
};

TEST_F(HomePlans, HaveRoomsDoorsAndWindows) {
  const HomePlan plan = readTwoRooms(
      R"(, "name": "flat", "light": "day",
         "doors": [{"at": [2.5, 2], "axis": "x", "width": 0.8, "rooms": ["hall", "bath"]}],
         "windows": [{"at": [4, 3], "axis": "y", "width": 0.5, "room": "bath"}])");
  EXPECT_EQ(plan.name, "flat");
  ASSERT_EQ(plan.rooms.size(), 2U);
  EXPECT_EQ(plan.rooms[0].polygon.size(), 6U);
  EXPECT_EQ(plan.rooms[1].polygon[2], cv::Point2f(4, 4));
  ASSERT_EQ(plan.doors.size(), 1U);
  EXPECT_TRUE(plan.doors[0].alongX);
  EXPECT_EQ(plan.doors[0].at, cv::Point2f(2.5F, 2));
  EXPECT_FLOAT_EQ(plan.doors[0].width, 0.8F);
  EXPECT_THAT(plan.doors[0].rooms, ElementsAre("hall", "bath"));
  ASSERT_EQ(plan.windows.size(), 1U);
  EXPECT_FALSE(plan.windows[0].alongX);
  EXPECT_THAT(plan.windows[0].rooms, ElementsAre("bath"));
}

TEST_F(HomePlans, SayInWhichRoomAPositionLies) {
  const HomePlan plan = readTwoRooms("");
  EXPECT_EQ(roomAt(plan, 1, 3), 0U);
  EXPECT_EQ(roomAt(plan, 3, 3), 1U) << "inside of the hall's box, outside of its polygon";
  EXPECT_EQ(roomAt(plan, 3, 2), 0U) << "on the edge of both";
  EXPECT_EQ(roomAt(plan, 4, 4), 1U) << "a corner";
  EXPECT_EQ(roomAt(plan, 4.01, 3), std::nullopt);
  EXPECT_EQ(roomAt(plan, 1e300, -1e300), std::nullopt);
}

TEST_F(HomePlans, RefuseWhatIsNoPlan) {
  for (const std::string& text :
       {std::string("{"), std::string("[]"), std::string("{}"), std::string(R"({"rooms": []})"),
        std::string(R"({"rooms": {}})"), std::string(R"({"rooms": [7]})"), std::string(R"({"rooms": [NaN]})"),
        std::string(R"({"rooms": [{"name": "a"}]})"), std::string(80, '[') + std::string(80, ']'),
        fmt::format(R"({{"rooms": [{}, {}]}})", kBath, kBath)})
    EXPECT_THAT(reading(text), FailsWith(ErrorCode::malformedFile)) << text;
  EXPECT_THAT([&] { readHomePlan(folder_ / "none.json"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(HomePlans, RefusePolygonsThatAreNone) {
  for (const char* polygon :
       {"[[0, 0], [4, 0]]", "[[0, 0], [1, 1], [2, 2]]", "[[0, 0], [1, 0], [1, 1e9]]", "[[0, 0], [1, 0], [1]]",
        "[[0, 0], [1, 0], [1, null]]", "[[0, 0], [1, 0], [1, NaN]]", "[[0, 0], [1, 0], [1, 1e999]]"})
    EXPECT_THAT(reading(fmt::format(R"({{"rooms": [{{"name": "a", "polygon": {}}}]}})", polygon)),
                FailsWith(ErrorCode::malformedFile))
        << polygon;
  std::string corners = "[0, 0]";
  for (int i = 0; i < 1000; ++i) corners += fmt::format(", [{}, {}]", i + 1, i * i % 7);
  EXPECT_THAT(reading(fmt::format(R"({{"rooms": [{{"name": "a", "polygon": [{}]}}]}})", corners)),
              FailsWith(ErrorCode::tooLarge));
}

TEST_F(HomePlans, RefuseOpeningsOfNoRoom) {
  const auto door = [&](const std::string& text) {
    return [this, text] { readTwoRooms(R"(, "doors": [{"at": [2, 2], )" + text + "}]"); };
  };
  EXPECT_NO_THROW(door(R"("axis": "x", "width": 1, "rooms": ["hall"])")());
  for (const char* text : {R"("axis": "x", "width": 1, "rooms": ["hall", "attic"])",
                           R"("axis": "z", "width": 1, "rooms": ["hall"])",
                           R"("axis": "x", "width": 0, "rooms": ["hall"])", R"("axis": "x", "width": 1)"})
    EXPECT_THAT(door(text), FailsWith(ErrorCode::malformedFile)) << text;
}

}  // namespace
}  // namespace estancia::io
