// Parts of a data set, and NYU Depth V2, which publishes its own.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "estancia/io/sequence.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::encoded;
using test::FailsWith;
using test::Mentions;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> namesOf(const Sequence& sequence) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sequence.size(); ++i) names.push_back(sequence.frame(i).name);
  return names;
}

std::vector<std::string> roomsOf(const Sequence& sequence) {
  std::vector<std::string> rooms;
  for (std::size_t i = 0; i < sequence.size(); ++i) rooms.push_back(sequence.frame(i).room);
  return rooms;
}

class Splits : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 6; ++i)
      test::writeFile(folder_ / fmt::format("{}.png", i),
                      encoded(".png", test::plain(2, 2, {1, 2, i * 1.0})));
    test::writeFile(folder_ / "rooms.csv",
                    "image,room,split\n0.png,hall,train\n1.png,hall,test\n2.png,office,train\n"
                    "3.png,kitchen,test\n4.png,,train\n");
  }
  std::unique_ptr<Sequence> open(const std::string& split, std::vector<std::string> only = {}) {
    SequenceOptions options;
    options.split = split;
    options.only = std::move(only);
    return openSequence(folder_.path(), options);
  }
  test::Caught refusal(const std::string& split, std::vector<std::string> only = {}) {
    return test::caught([&] { open(split, std::move(only)); });
  }
  test::ScratchFolder folder_;
};

TEST_F(Splits, AreTheThirdColumnOfTheRooms) {
  EXPECT_EQ(open("")->size(), 6U);
  const auto train = open("train");
  EXPECT_THAT(namesOf(*train), ElementsAre("0.png", "2.png", "4.png"));
  EXPECT_THAT(roomsOf(*train), ElementsAre("hall", "office", ""));
  EXPECT_EQ(train->image(1).at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 2));
  EXPECT_EQ(train->fingerprint(1), open("")->fingerprint(2));
  EXPECT_EQ(train->name(), open("")->name() + " (train)");
  EXPECT_THAT(namesOf(*open("test")), ElementsAre("1.png", "3.png"));
}

TEST_F(Splits, OnlyTheRoomsThatAreNamedAreLeft) {
  EXPECT_THAT(namesOf(*open("", {"kitchen", "hall"})), ElementsAre("0.png", "1.png", "3.png"));
  EXPECT_THAT(namesOf(*open("train", {"kitchen", "hall"})), ElementsAre("0.png"));
}

TEST_F(Splits, RoomsAreUnderstoodInOtherWords) {
  const auto sure = open("", {"Kitchens", "HALL"});
  EXPECT_THAT(namesOf(*sure), ElementsAre("0.png", "1.png", "3.png"));
  EXPECT_THAT(sure->warnings(), IsEmpty()) << "it is the same name";
  const auto corrected = open("train", {"hallway", "ofice"});
  EXPECT_THAT(namesOf(*corrected), ElementsAre("0.png", "2.png"));
  EXPECT_THAT(corrected->warnings(),
              ElementsAre("no room is called \"hallway\": hall is taken, the same as hallway",
                          "no room is called \"ofice\": office is taken, by its spelling"));
  EXPECT_THAT(namesOf(*open("", {"kichen", "kitchen"})), ElementsAre("3.png")) << "once";
  EXPECT_THAT(refusal("", {"corridor"}), FailsWith(ErrorCode::unknownName));
}

TEST_F(Splits, UnknownOnesAreRefused) {
  EXPECT_THAT(refusal("valid"), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT(refusal("", {"hall", "attic"}), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT(refusal("train", {"kitchen"}), FailsWith(ErrorCode::insufficientData));
  std::filesystem::remove(folder_ / "rooms.csv");
  EXPECT_THAT(refusal("train"), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(refusal("", {"hall"}), FailsWith(ErrorCode::insufficientData));
}

// ---- NYU Depth V2

class Nyu : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const int i : {7, 8, 10, 100}) {
      test::writeFile(folder_ / fmt::format("rgb/{:04}.jpg", i), encoded(".jpg", test::texture(8, 6)));
      test::writeFile(folder_ / fmt::format("depth/{:04}.png", i),
                      encoded(".png", cv::Mat(6, 8, CV_8U, cv::Scalar(i == 7 ? 255 : 51))));
    }
    table(
        "index,split,scene,label_source\n7,test,kitchen,official\n8,train,office,block\n"
        "100,train,\"home, office\",block\n");
  }
  void table(const std::string& text) { test::writeFile(folder_ / "scenes.csv", text); }
  std::unique_ptr<Sequence> open(const std::string& split = "") {
    SequenceOptions options;
    options.split = split;
    return openSequence(folder_.path(), options);
  }
  test::Caught refusal() {
    return test::caught([&] { open(); });
  }
  test::ScratchFolder folder_;
};

TEST_F(Nyu, KnowsRoomsHalvesDepthAndCamera) {
  const auto all = open();
  EXPECT_THAT(namesOf(*all), ElementsAre("0007.jpg", "0008.jpg", "0010.jpg", "0100.jpg"));
  EXPECT_THAT(roomsOf(*all), ElementsAre("kitchen", "office", "", "home, office"));
  EXPECT_THAT(all->warnings(), IsEmpty());
  EXPECT_TRUE(all->hasDepth());
  EXPECT_EQ(all->depth(0).at<float>(3, 3), 10);
  EXPECT_EQ(all->depth(1).at<float>(3, 3), 2);
  const CameraIntrinsics camera = all->intrinsics()->scaledTo(320, 240);
  EXPECT_NEAR(camera.fx, 518.858 / 2, 1e-3);
  EXPECT_NEAR(camera.fy, 519.470 / 2, 1e-3);
  EXPECT_THAT(namesOf(*open("train")), ElementsAre("0008.jpg", "0100.jpg"));
  EXPECT_EQ(open("test")->depth(0).at<float>(0, 0), 10);
}

TEST_F(Nyu, ColumnsMayStandInAnyOrderAndLinesMayLackImages) {
  table("scene,index\nkitchen,0008\nhall,9\n");
  EXPECT_THAT(roomsOf(*open()), ElementsAre("", "kitchen", "", ""));
  EXPECT_THAT(open()->warnings(), ElementsAre(Mentions({"1 of 2", "scenes.csv"})));
  EXPECT_THAT([&] { open("train"); }, FailsWith(ErrorCode::insufficientData));
}

TEST_F(Nyu, RefusesAWrongTable) {
  for (const char* text :
       {"index,scene\n7,kitchen\n8\n", "index,scene\nseven,kitchen\n",
        "index,scene\n99999999999999999999,kitchen\n", "index,scene\n7,kitchen\n0007,hall\n"}) {
    table(text);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile)) << text;
  }
}

TEST(RealNyu, HasItsHalvesAndRooms) {
  const auto data = test::findData("nyuv2_half");
  ESTANCIA_NEEDS(data, "the real data set nyuv2_half is missing");
  const auto all = openSequence(*data);
  EXPECT_EQ(all->size(), 1173U);
  EXPECT_THAT(all->warnings(), IsEmpty());
  SequenceOptions options;
  options.split = "test";
  EXPECT_EQ(openSequence(*data, options)->size(), 654U);
  options.only = {"bathroom", "bedroom", "kitchen", "living_room", "dining_room"};
  const auto test = openSequence(*data, options);
  options.split = "train";
  const auto train = openSequence(*data, options);
  EXPECT_EQ(test->size() + train->size(), 957U);
  std::map<std::string, int> rooms;
  for (const std::string& room : roomsOf(*test)) ++rooms[room];
  EXPECT_THAT(rooms, ::testing::SizeIs(5));
}

}  // namespace
}  // namespace estancia
