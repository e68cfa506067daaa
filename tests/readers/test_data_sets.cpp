// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::encoded;
using test::FailsWith;
using test::Mentions;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::string& tinyPng() {
  static const std::string bytes = test::encoded(".png", test::plain(1, 1, {1, 2, 3}));
  return bytes;
}

double headingOf(const Pose& pose) {
  return std::atan2(pose.forward()[1], pose.forward()[0]);
}

// ---- KTH-IDOL2

TEST(Idol2, ReadsTheTruthInFileNames) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "t1138022370.198380_rCR_x-1.5e-05_y8.5_a-3.1.jpg", tinyPng());
  test::writeFile(folder / "t1138022369.798380_rPA_x6.31979_y8.54727_a-1.63046.png", tinyPng());
  test::writeFile(folder / "plan.png", tinyPng());
  const auto sequence = openSequence(folder.path());
  ASSERT_EQ(sequence->size(), 2U);
  const Frame& frame = sequence->frame(0);
  EXPECT_EQ(frame.timestamp, 1138022369.79838);
  EXPECT_EQ(frame.room, "PA");
  EXPECT_EQ(frame.pose->x, 6.31979);
  EXPECT_EQ(frame.pose->y, 8.54727);
  EXPECT_NEAR(headingOf(*frame.pose), -1.63046, 1e-9);
  EXPECT_EQ(sequence->frame(1).pose->x, -1.5e-05);
  EXPECT_EQ(sequence->frame(1).room, "CR");
  EXPECT_THAT(sequence->warnings(), ElementsAre(Mentions({"1 image", "plan.png"})));
}

// ---- TUM RGB-D

class TumRgbd : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) { test::writeFile(folder_ / name, text); }
  std::unique_ptr<Sequence> open() { return openSequence(folder_.path()); }
  test::ScratchFolder folder_;
};

TEST_F(TumRgbd, TakesTheNearestPoseOfADenserTrajectory) {
  for (const char* name : {"rgb/1.png", "rgb/a b.png", "rgb/3.png"}) write(name, tinyPng());
  write("rgb.txt",
        "# color images\n# timestamp filename\n1.00 rgb/1.png\n2.00 rgb/a b.png\n3.00 rgb/3.png\n");
  std::string truth = "# ground truth\n";
  for (int i = 0; i <= 100; ++i) truth += fmt::format("{:.3f} {} 0 0 0 0 0 1\n", 1.004 + i * 0.01, i);
  write("groundtruth.txt", truth);
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 3U);
  EXPECT_EQ(sequence->frame(1).name, "rgb/a b.png");
  EXPECT_EQ(sequence->frame(1).timestamp, 2.0);
  EXPECT_EQ(sequence->frame(0).pose->x, 0);
  EXPECT_EQ(sequence->frame(1).pose->x, 100);
  EXPECT_FALSE(sequence->frame(2).pose);
  EXPECT_THAT(sequence->warnings(), ElementsAre(Mentions({"1 of 3"})));
  EXPECT_EQ(sequence->image(1).at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
}

TEST_F(TumRgbd, DoesNotLeaveItsFolder) {
  for (const char* path : {"../secret.png", "rgb/../../secret.png", "/etc/secret.png", "..", "."}) {
    write("rgb.txt", fmt::format("1 {}\n", path));
    const test::Caught caught = test::caught([&] { open()->image(0); });
    if (std::string(path) == ".")
      EXPECT_TRUE(caught.code);
    else
      EXPECT_THAT(caught, FailsWith(ErrorCode::unsafePath)) << path;
  }
}

TEST_F(TumRgbd, RefusesAWrongList) {
  for (const char* text : {"1 a.png\nnoon b.png\n", "1 a.png\n2\n"}) {
    write("rgb.txt", text);
    EXPECT_THAT([&] { open(); }, FailsWith(ErrorCode::malformedFile)) << text;
  }
  write("rgb.txt", "# nothing\n");
  EXPECT_THAT([&] { open(); }, FailsWith(ErrorCode::insufficientData));
}

// ---- 7-Scenes

TEST(SevenScenes, ReadsOnePoseFileAFrame) {
  const test::ScratchFolder folder;
  for (int i : {0, 1, 2, 3, 10}) test::writeFile(folder / fmt::format("frame-{:06}.color.png", i), tinyPng());
  test::writeFile(folder / "frame-000000.depth.png", tinyPng());
  // Looks along the world's x axis from (1, 2, 3): camera x → −y, y → −z, z → x.
  test::writeFile(folder / "frame-000000.pose.txt", "0 0 1 1\t\n-1 0 0 2\t\n0 -1 0 3\t\n0 0 0 1\t\n");
  test::writeFile(folder / "frame-000001.pose.txt",
                  "-1.#IND nan nan nan\n nan nan nan nan\nnan nan nan nan\n0 0 0 1\n");
  test::writeFile(folder / "frame-000002.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n");
  const auto sequence = openSequence(folder.path());
  ASSERT_EQ(sequence->size(), 5U);
  EXPECT_EQ(sequence->frame(4).name, "frame-000010.color.png");
  EXPECT_FALSE(sequence->frame(0).timestamp);
  const Pose pose = sequence->frame(0).pose.value();
  EXPECT_EQ(pose.y, 2);
  EXPECT_NEAR(pose.forward()[0], 1, 1e-12);
  for (std::size_t i : {1U, 2U, 3U}) EXPECT_FALSE(sequence->frame(i).pose) << i;
  EXPECT_THAT(sequence->warnings(), ElementsAre(Mentions({"4 of 5", "frame-000001.color.png"})));
  test::writeFile(folder / "frame-000003.pose.txt", "1 0 0\n");
  EXPECT_THAT([&] { openSequence(folder.path()); }, FailsWith(ErrorCode::malformedFile));
}

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

TEST_F(Splits, KeepWhatIsKnownOfTheWhole) {
  std::string poses;
  for (int i = 0; i < 6; ++i) poses += fmt::format("{} {} 0 0 0 0 0 1\n", 100 + i, i);
  test::writeFile(folder_ / "poses.txt", poses);
  test::writeFile(folder_ / "intrinsics.txt", "5 5 1 1\n");
  const auto test = open("test");
  EXPECT_EQ(test->frame(1).pose->x, 3) << "poses go by the order of all frames, not of the part";
  EXPECT_EQ(test->intrinsics()->fx, 5);
}

TEST_F(Splits, RoomsAreUnderstoodInOtherWords) {
  const auto sure = open("", {"Kitchens", "HALL"});
  EXPECT_THAT(namesOf(*sure), ElementsAre("0.png", "1.png", "3.png"));
  EXPECT_THAT(sure->warnings(), IsEmpty()) << "it is the same name";
  const auto corrected = open("train", {"hallway", "ofice"});
  EXPECT_THAT(namesOf(*corrected), ElementsAre("0.png", "2.png"));
  EXPECT_EQ(corrected->warnings().size(), 2U);
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

TEST_F(Nyu, RefusesAWrongTable) {
  for (const char* text :
       {"index,scene\n7,kitchen\n8\n", "index,scene\nseven,kitchen\n",
        "index,scene\n99999999999999999999,kitchen\n", "index,scene\n7,kitchen\n0007,hall\n"}) {
    table(text);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile)) << text;
  }
}

/// A wall at `z` meters before a camera of 16 × 12 pixels, fx 20, fy 22, cx 7, cy 5.5, with a hole at (3, 2).
std::string cloudAt(float z) {
  std::string bytes = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 16\nHEIGHT 12\nDATA binary\n";
  for (int v = 0; v < 12; ++v)
    for (int u = 0; u < 16; ++u) {
      const bool hole = u == 3 && v == 2;
      const float depth = hole ? std::nanf("") : z + 0.01F * static_cast<float>(u);
      const float point[3] = {depth * static_cast<float>(u - 7) / 20,
                              depth * (static_cast<float>(v) - 5.5F) / 22, depth};
      const auto* begin = reinterpret_cast<const char*>(point);
      bytes.append(begin, begin + sizeof point);
    }
  return bytes;
}

class Vidrilo : public ::testing::Test {
 protected:
  void images(const std::string& pattern, const std::vector<int>& numbers) {
    for (const int n : numbers)
      test::writeFile(folder_ / fmt::format(fmt::runtime(pattern), n),
                      test::encoded(".png", test::plain(16, 12, {1, 2, n * 1.0})));
  }
  void clouds(const std::string& pattern, const std::vector<int>& numbers) {
    for (const int n : numbers)
      test::writeFile(folder_ / fmt::format(fmt::runtime(pattern), n), cloudAt(static_cast<float>(n)));
  }
  void asPublished() {
    images("Visual/sequence1visual{}.png", {1, 2, 10});
    clouds("Depth/sequence1depth{}.pcd", {1, 2, 10});
  }
  std::unique_ptr<Sequence> open(const std::string& type = "auto") {
    SequenceOptions options;
    options.type = type;
    return openSequence(folder_.path(), options);
  }
  std::vector<std::string> rooms() {
    const auto sequence = open();
    std::vector<std::string> all;
    for (std::size_t i = 0; i < sequence->size(); ++i) all.push_back(sequence->frame(i).room);
    return all;
  }
  void annotate(const std::string& text, const std::string& name = "annotations.txt") {
    test::writeFile(folder_ / name, text);
  }
  test::ScratchFolder folder_;
};

TEST_F(Vidrilo, PairsImagesAndCloudsByNumber) {
  asPublished();
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 3U);
  EXPECT_EQ(sequence->frame(2).name, "sequence1visual10.png");
  EXPECT_EQ(sequence->image(2).at<cv::Vec3b>(0, 0)[2], 10);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  ASSERT_TRUE(sequence->hasDepth());
  const cv::Mat depth = sequence->depth(2);
  ASSERT_EQ(depth.size(), cv::Size(16, 12));
  EXPECT_FLOAT_EQ(depth.at<float>(5, 4), 10.04F);
  EXPECT_EQ(depth.at<float>(2, 3), 0);
}

TEST_F(Vidrilo, FindsTheCameraInTheClouds) {
  asPublished();
  const auto camera = open()->intrinsics();
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->width, 16);
  EXPECT_NEAR(camera->fx, 20, 1e-3);
  EXPECT_NEAR(camera->fy, 22, 1e-3);
  EXPECT_NEAR(camera->cx, 7, 1e-3);
  EXPECT_NEAR(camera->cy, 5.5, 1e-3);
}

TEST_F(Vidrilo, ReadsAnnotationsInSeveralForms) {
  asPublished();
  EXPECT_THAT(rooms(), ElementsAre("", "", ""));
  annotate("Corridor 0 1\nToilet 1 0\nElevatorArea 0 0\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "ElevatorArea")) << "in the order of the images";
  annotate("10;Elevator Area;0;1\n1;\"Corridor\";1;1\n2;Toilet;0;0\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "Elevator Area")) << "by number";
  annotate(
      "# of sequence 1\nsequence1visual2.png sequence1depth2.pcd 5 1\nsequence1visual1.png "
      "sequence1depth1.pcd 7 0\n");
  EXPECT_THAT(rooms(), ElementsAre("7", "5", "")) << "by file; categories may be numbers";
  annotate("x,y,Category,frame\n0.5,1,Corridor,1\n0.6,1,Toilet,2\n0.7,2,Hall,99\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "")) << "by a header";
  annotate("image,room\nsequence1visual1.png,Warehouse\n", "rooms.csv");
  EXPECT_THAT(rooms(), ElementsAre("Warehouse", "Toilet", "")) << "rooms.csv has the last word";
}

TEST_F(Vidrilo, ReadsPosesOfTheThesisAuthorsTables) {
  asPublished();
  annotate("Sequence 1\n10 2.5 -1 3.1 Toilet\n1 0.5 1 -0.25 Corridor\n", "Sequence1.txt");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "", "Toilet")) << "below a title: index x y theta category";
  auto sequence = open();
  ASSERT_TRUE(sequence->frame(0).pose);
  EXPECT_EQ(sequence->frame(0).pose->y, 1);
  EXPECT_NEAR(sequence->frame(0).pose->qz, Pose::planar(0.5, 1, -0.25).qz, 1e-12);
  EXPECT_FALSE(sequence->frame(1).pose);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  annotate("index,category,theta,y,x\n2,Hall,90,4,3\n", "Sequence1.txt");
  sequence = open();
  EXPECT_EQ(sequence->frame(1).pose->x, 3);
  EXPECT_NEAR(sequence->frame(1).pose->qz, Pose::planar(3, 4, std::numbers::pi / 2).qz, 1e-12) << "degrees";
}

TEST_F(Vidrilo, TablesThatDoNotFitAreLeftOutWithAWarning) {
  asPublished();
  for (const char* table :
       {"Corridor 0\nToilet\nHall 1\n", "a.png\nb.png\nc.png\n", "0.5 1.5\n0.6 2.5\n0.7 1\n", "",
        "image,room\nsequence1visual1.png\n", "Corridor\nHall\n", "one\ntwo 2\nthree 3 3\n"}) {
    annotate(table);
    EXPECT_THAT(rooms(), ElementsAre("", "", "")) << table;
    EXPECT_EQ(open()->warnings().size(), 1U) << table;
  }
}

TEST_F(Vidrilo, FoldersThatAreNoneAreRefused) {
  images("Visual/a{}.png", {1, 2});
  EXPECT_THAT([&] { open("vidrilo"); }, FailsWith(ErrorCode::unsupportedFile)) << "no clouds";
  clouds("Depth/b{}.pcd", {7});
  EXPECT_THAT([&] { open("vidrilo"); }, FailsWith(ErrorCode::mismatch)) << "no number in common";
  clouds("Depth/b{}.pcd", {1});
  EXPECT_THAT(open("vidrilo")->warnings(), ::testing::SizeIs(1)) << "one image has no cloud";
  images("Visual/c{}.png", {1});
  EXPECT_THAT([&] { open("vidrilo"); }, FailsWith(ErrorCode::malformedFile)) << "two have the number 1";
}

TEST_F(Vidrilo, ADamagedCloudSpoilsItsOwnFrameOnly) {
  asPublished();
  test::writeFile(folder_ / "Depth/sequence1depth1.pcd", cloudAt(1).substr(0, 500));
  const auto sequence = open();
  EXPECT_TRUE(sequence->intrinsics());
  EXPECT_THAT([&] { sequence->depth(0); }, FailsWith(ErrorCode::truncatedFile));
  EXPECT_FALSE(sequence->depth(1).empty());
}

TEST(SevenScenes, NamesTheWrongLineOfThePoseTable) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "frames/frame-000005.color.jpg", tinyPng());
  const std::string header = "frame,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n";
  test::writeFile(folder / "poses.csv", header + "5,1,0,0,4,0,1,0,5,0,0,1,6\n");
  EXPECT_EQ(openSequence(folder.path())->frame(0).pose->z, 6);
  test::writeFile(folder / "poses.csv", header + "5,1,0,0,4,0,1\n");
  EXPECT_THAT([&] { openSequence(folder.path()); }, FailsWith(ErrorCode::malformedFile));
}

TEST(SevenScenes, APhotographOfThatNameMakesNoDataSet) {
  const test::ScratchFolder folder;
  for (const char* name : {"frame-000005.color.jpg", "kitchen.jpg", "hall.png"})
    test::writeFile(folder / name, tinyPng());
  EXPECT_EQ(openSequence(folder.path())->size(), 3U);
}

}  // namespace
}  // namespace estancia
