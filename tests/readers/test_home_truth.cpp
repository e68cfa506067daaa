// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <numbers>
#include <opencv2/core.hpp>

#include "estancia/files/home_plan.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"

namespace estancia::io {
namespace {

using test::encoded;
using test::FailsWith;
using test::writeFile;
using ::testing::_;
using ::testing::ElementsAre;
using ::testing::FieldsAre;

constexpr const char* instanceColumns =
    "id,category,model,model_name,room,x,y,z,size_x,size_y,size_z,yaw_degrees,movable_name\n";
constexpr const char* rug = "10,rug,*rug,generated,west,1,2,0.006,2.4,1.7,0.012,90,\n";
constexpr const char* mug = "300,mug,k28,\"Mug, \"\"red\"\"\",east,5,2,0.8,0.1,0.1,0.1,-45,mug\n";
/// Two rooms side by side, the robot's wall between them at x = 4.
constexpr const char* twoRooms =
    R"({"rooms": [{"name": "west", "polygon": [[0, 0], [4, 0], [4, 4], [0, 4]]},
                  {"name": "east", "polygon": [[4, 0], [8, 0], [8, 4], [4, 4]]}]})";

/// A camera at x = 2, y = 2 that looks east; what it sees at 2 m is the wall.
const Pose looksEast = Pose::planar(2, 2, 0);
constexpr CameraIntrinsics kCamera{16, 12, 16, 16, 7.5, 5.5};

class HomeTruthFiles : public ::testing::Test {
 protected:
  std::vector<HomeInstance> instances(const std::string& rows) {
    writeFile(folder_ / "instances.csv", instanceColumns + rows);
    return readHomeInstances(folder_ / "instances.csv");
  }
  VisibleByImage visible(const std::string& rows) {
    writeFile(folder_ / "visible.csv", "image,id,pixels,pixels_with_depth\n" + rows);
    return readVisibleInstances(folder_ / "visible.csv", instances(std::string(rug) + mug));
  }
  HomePlan plan() {
    writeFile(folder_ / "home.json", twoRooms);
    return readHomePlan(folder_ / "home.json");
  }
  test::ScratchFolder folder_;
};

TEST_F(HomeTruthFiles, ListInstancesWithTheirBoxes) {
  const auto found = instances(std::string(rug) + mug);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_THAT(found[0], FieldsAre(10, "rug", "*rug", "generated", "west", cv::Point3d(1, 2, 0.006),
                                  cv::Point3d(2.4, 1.7, 0.012), testing::DoubleEq(std::numbers::pi / 2), ""));
  EXPECT_THAT(found[1], FieldsAre(300, "mug", "k28", "Mug, \"red\"", "east", _, _, _, "mug"));
}

TEST_F(HomeTruthFiles, RefuseInstancesThatCannotBe) {
  for (const std::string& rows :
       {std::string(rug) + mug + rug, std::string("9,rug,a,b,west,1,2,0,1,1,1,0,\n"),
        std::string("65536,rug,a,b,west,1,2,0,1,1,1,0,\n"), std::string("10.5,rug,a,b,west,1,2,0,1,1,1,0,\n"),
        std::string("10,rug,a,b,west,nan,2,0,1,1,1,0,\n"), std::string("10,rug,a,b,west,1,1e5,0,1,1,1,0,\n"),
        std::string("10,rug,a,b,west,1,2,0,-1,1,1,0,\n"), std::string("10,rug,a,b,west,1,2,0,1,1,1,,\n"),
        std::string("10,rug,a,b\n")})
    EXPECT_THAT([&] { instances(rows); }, FailsWith(ErrorCode::malformedFile)) << rows;
  EXPECT_TRUE(instances("").empty()) << "an empty home";
  for (const char* text : {"id,category\n10,rug\n", ""}) {
    writeFile(folder_ / "instances.csv", text);
    EXPECT_THAT([&] { readHomeInstances(folder_ / "instances.csv"); }, FailsWith(ErrorCode::malformedFile));
  }
}

TEST_F(HomeTruthFiles, SayWhatAFrameSees) {
  const auto seen = visible("a.jpg,10,500,400\na.jpg,300,20,0\nb.jpg,300,7,7\n");
  ASSERT_EQ(seen.at("a.jpg").size(), 2U);
  EXPECT_EQ(seen.at("a.jpg")[0].pixels, 500);
  EXPECT_EQ(seen.at("a.jpg")[0].pixelsWithDepth, 400);
  EXPECT_EQ(seen.at("b.jpg")[0].id, 300);
}

TEST_F(HomeTruthFiles, RefuseVisibleInstancesThatCannotBe) {
  for (const char* row :
       {"a.jpg,11,5,5\n", "a.jpg,10,5,6\n", "a.jpg,10,-1,-1\n", "a.jpg,10,1e9,5\n", "a.jpg,10,nan,5\n",
        "a.jpg,10,5.5,5\n", "a.jpg,10,5\n", "a.jpg,10,5,5\na.jpg,10,5,5\n"})
    EXPECT_THAT([&] { visible(row); }, FailsWith(ErrorCode::malformedFile)) << row;
}

TEST_F(HomeTruthFiles, HaveMasksOf16Bits) {
  const cv::Mat mask = (cv::Mat_<std::uint16_t>(2, 2) << 0, 3, 10, 300);
  writeFile(folder_ / "instance/000001.png", encoded(".png", mask));
  Frame frame;
  frame.name = "000001.jpg";
  const cv::Mat read = readInstanceMask(instanceMaskFile(folder_.path(), frame));
  ASSERT_EQ(read.type(), CV_16UC1);
  EXPECT_EQ(cv::countNonZero(read != mask), 0);
  writeFile(folder_ / "8.png", encoded(".png", cv::Mat(2, 2, CV_8U, cv::Scalar(1))));
  writeFile(folder_ / "color.png", encoded(".png", cv::Mat(2, 2, CV_16UC3, cv::Scalar(1, 2, 3))));
  writeFile(folder_ / "none.png", "no image");
  for (const char* name : {"8.png", "color.png", "none.png"})
    EXPECT_THAT([&] { readInstanceMask(folder_ / name); }, FailsWith(ErrorCode::unsupportedFile)) << name;
}

TEST_F(HomeTruthFiles, TellTheRoomThatMostOfTheDepthLiesIn) {
  const HomePlan home = plan();
  cv::Mat depth(12, 16, CV_32F, cv::Scalar(1.5));
  EXPECT_EQ(roomSeen(home, depth, kCamera, looksEast), 0U);
  depth = 2;
  EXPECT_EQ(roomSeen(home, depth, kCamera, looksEast), 0U) << "a wall belongs to the side that is seen";
  depth.colRange(0, 9) = 3;
  EXPECT_EQ(roomSeen(home, depth, kCamera, looksEast), 1U) << "through a door";
  depth.colRange(0, 9) = 0;
  EXPECT_EQ(roomSeen(home, depth, kCamera, looksEast), 0U) << "no depth, no vote";
  EXPECT_EQ(roomSeen(home, depth, kCamera, Pose::planar(2, 2, std::numbers::pi)), 0U);
  EXPECT_EQ(roomSeen(home, depth, kCamera, Pose::planar(100, 2, 0)), std::nullopt);
}

TEST_F(HomeTruthFiles, FramesWithoutDepthSeeTheRoomOfTheirThings) {
  plan();
  visible("1.jpg,300,5,0\n2.jpg,300,5,0\n");
  for (const char* name : {"1", "2", "3"})
    writeFile(folder_ / (std::string("rgb/") + name + ".jpg"),
              encoded(".jpg", test::plain(16, 12, {9, 9, 9})));
  writeFile(folder_ / "depth/1.png", encoded(".png", cv::Mat(12, 16, CV_16U, cv::Scalar(1000))));
  writeFile(folder_ / "camera-intrinsics.txt", "16 0 7.5\n0 16 5.5\n0 0 1\n");
  writeFile(folder_ / "poses.txt", "0 2 2 1 -0.5 0.5 -0.5 0.5\n1 2 2 1 -0.5 0.5 -0.5 0.5\n2 2 2 1 0 0 0 1\n");
  ASSERT_TRUE(hasHomeTruth(folder_.path()));
  const HomeTruth truth = readHomeTruth(folder_.path());
  EXPECT_THAT(roomsSeen(truth, *openSequence(folder_.path())), ElementsAre("west", "east", ""));
  const auto seenBy = [&](const std::vector<std::string>& images) {
    return roomsSeen(folder_.path(), images);
  };
  EXPECT_THAT(seenBy({"rgb/2.jpg", "1.jpg"}), ElementsAre("east", "west"));
  EXPECT_TRUE(seenBy({}).empty());
  EXPECT_THAT([&] { seenBy({"1.jpg", "4.jpg"}); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { seenBy({"1.jpg", "1.jpg"}); }, FailsWith(ErrorCode::mismatch));
  writeFile(folder_ / "depth/1.png", "damaged");
  EXPECT_THAT(roomsSeen(truth, *openSequence(folder_.path())), ElementsAre("east", "east", ""));
}

/// A hall that is L-shaped around a bath, which lies in its upper right corner.
constexpr const char* hall =
    R"({"name": "hall", "polygon": [[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4]]})";
constexpr const char* bath = R"({"name": "bath", "polygon": [[2, 2], [4, 2], [4, 4], [2, 4]]})";

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
    return read(std::string(R"({"rooms": [)") + hall + "," + bath + "]" + openings + "}");
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
        fmt::format(R"({{"rooms": [{}, {}]}})", bath, bath)})
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

TEST_F(HomeTruthFiles, AFolderNeedsOnlyThePlan) {
  EXPECT_FALSE(hasHomeTruth(folder_.path()));
  plan();
  const HomeTruth truth = readHomeTruth(folder_.path());
  EXPECT_EQ(truth.plan.rooms.size(), 2U);
  EXPECT_TRUE(truth.instances.empty());
  EXPECT_TRUE(truth.visible.empty());
}

TEST_F(HomeTruthFiles, NoDepthShowsNoRoom) {
  const HomePlan home = plan();
  cv::Mat depth(12, 16, CV_32F, cv::Scalar(0));
  EXPECT_EQ(roomSeen(home, depth, kCamera, looksEast), std::nullopt);
  depth = std::nan("");
  EXPECT_EQ(roomSeen(home, depth, kCamera, looksEast), std::nullopt);
  EXPECT_THAT([&] { roomSeen(home, cv::Mat(), kCamera, looksEast); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { roomSeen(home, cv::Mat(2, 2, CV_16U), kCamera, looksEast); },
              FailsWith(ErrorCode::invalidInput));
}

TEST_F(HomeTruthFiles, TellTheRoomOfMostVisibleThings) {
  const auto things = instances(std::string(rug) + mug + "11,lamp,a,b,east,5,2,0,1,1,1,0,\n" +
                                "12,cloud,a,b,,5,2,0,1,1,1,0,\n");
  EXPECT_EQ(roomSeen({{10, 50, 50}, {300, 30, 0}, {11, 30, 0}, {12, 900, 0}}, things), "east");
  EXPECT_EQ(roomSeen({{10, 50, 50}, {300, 30, 0}}, things), "west");
  EXPECT_EQ(roomSeen({{12, 900, 0}}, things), "");
  EXPECT_EQ(roomSeen({}, things), "");
}

}  // namespace
}  // namespace estancia::io
