// Published data sets: the files as their authors left them, and such as they did not.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "readers/sequence_folder.hpp"

namespace estancia {
namespace {

using test::encoded;
using test::FailsWith;
using test::Mentions;
using test::namesOf;
using test::roomsOf;
using ::testing::_;
using ::testing::DoubleEq;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::FieldsAre;
using ::testing::IsEmpty;
using ::testing::Optional;

class Idol2 : public test::SequenceFolder {};

TEST_F(Idol2, ReadsTheTruthInFileNames) {
  for (const char* name : {"t1138022370.198380_rCR_x-1.5e-05_y8.5_a-3.1.jpg",
                           "t1138022369.798380_rPA_x6.31979_y8.54727_a-1.63046.png", "plan.png"})
    add(name);
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 2U);
  const auto pose = [](double x, double y, double theta) {
    const Pose p = Pose::planar(x, y, theta);
    return Optional(FieldsAre(x, y, 0, DoubleEq(p.qx), DoubleEq(p.qy), DoubleEq(p.qz), DoubleEq(p.qw)));
  };
  EXPECT_THAT(sequence->frame(0), FieldsAre(_, 1138022369.79838, pose(6.31979, 8.54727, -1.63046), "PA"));
  EXPECT_THAT(sequence->frame(1), FieldsAre(_, 1138022370.19838, pose(-1.5e-05, 8.5, -3.1), "CR"));
  EXPECT_THAT(sequence->warnings(), ElementsAre(Mentions({"1 image", "plan.png"})));
}

TEST_F(Idol2, TakesNoOtherNames) {
  for (const char* name :
       {"t1_rA_x1_y1.png", "t1_rA_x1_y1_b1.png", "t1_r_x1_y1_a1.png", "tx_rA_x1_y1_a1.png",
        "t1_rA_xx_y1_a1.png", "t1_rA_x1_yy_a1.png", "t1_rA_x1_y1_aa.png", "tnan_rA_x1_y1_a1.png"})
    add(name);
  EXPECT_THAT(refusal({.type = "idol2"}), FailsWith(ErrorCode::insufficientData));
  for (const char* name : {"t1_rA_xnan_y1_a1.png", "t2_rA_x1_yinf_a1.png", "t3_rA_x1_y1_anan.png"}) add(name);
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_FALSE(sequence->frame(i).pose) << i;
}

class TumRgbd : public test::SequenceFolder {};

TEST_F(TumRgbd, TakesTheNearestPoseOfADenserTrajectory) {
  for (const char* name : {"rgb/1.png", "rgb/a b.png", "rgb/3.png"}) add(name);
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
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile)) << text;
  }
  write("rgb.txt", "# nothing\n");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::insufficientData));
}

class SevenScenes : public test::SequenceFolder {};

TEST_F(SevenScenes, ReadsOnePoseFileAFrame) {
  for (int i : {0, 1, 2, 3, 10}) add(fmt::format("frame-{:06}.color.png", i));
  add("frame-000000.depth.png");
  // Looks along the world's x axis from (1, 2, 3): camera x → −y, y → −z, z → x.
  write("frame-000000.pose.txt", "0 0 1 1\t\n-1 0 0 2\t\n0 -1 0 3\t\n0 0 0 1\t\n");
  write("frame-000001.pose.txt", "-1.#IND nan nan nan\n nan nan nan nan\nnan nan nan nan\n0 0 0 1\n");
  write("frame-000002.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n");
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 5U);
  EXPECT_EQ(sequence->frame(4).name, "frame-000010.color.png");
  EXPECT_FALSE(sequence->frame(0).timestamp);
  const Pose pose = sequence->frame(0).pose.value();
  EXPECT_EQ(pose.y, 2);
  EXPECT_NEAR(pose.forward()[0], 1, 1e-12);
  for (std::size_t i : {1U, 2U, 3U}) EXPECT_FALSE(sequence->frame(i).pose) << i;
  EXPECT_THAT(sequence->warnings(), ElementsAre(Mentions({"4 of 5", "frame-000001.color.png"})));
  write("frame-000003.pose.txt", "1 0 0\n");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile));
}

class Splits : public test::SequenceFolder {
 protected:
  void SetUp() override {
    for (int i = 0; i < 6; ++i) add(fmt::format("{}.png", i), i);
    write("rooms.csv",
          "image,room,split\n0.png,hall,train\n1.png,hall,test\n2.png,office,train\n"
          "3.png,kitchen,test\n4.png,,train\n");
  }
};

TEST_F(Splits, AreTheThirdColumnOfTheRooms) {
  EXPECT_EQ(open()->size(), 6U);
  const auto train = open({.split = "train"});
  EXPECT_THAT(namesOf(*train), ElementsAre("0.png", "2.png", "4.png"));
  EXPECT_THAT(roomsOf(*train), ElementsAre("hall", "office", ""));
  EXPECT_EQ(train->image(1).at<cv::Vec3b>(0, 0), cv::Vec3b(2, 2, 3));
  EXPECT_EQ(train->fingerprint(1), open()->fingerprint(2));
  EXPECT_EQ(train->name(), open()->name() + " (train)");
  EXPECT_THAT(namesOf(*open({.split = "test"})), ElementsAre("1.png", "3.png"));
}

TEST_F(Splits, KeepWhatIsKnownOfTheWhole) {
  std::string poses;
  for (int i = 0; i < 6; ++i) poses += fmt::format("{} {} 0 0 0 0 0 1\n", 100 + i, i);
  write("poses.txt", poses);
  write("intrinsics.txt", "5 5 1 1\n");
  const auto test = open({.split = "test"});
  EXPECT_EQ(test->frame(1).pose->x, 3) << "poses go by the order of all frames, not of the part";
  EXPECT_EQ(test->intrinsics()->fx, 5);
}

TEST_F(Splits, RoomsAreUnderstoodInOtherWords) {
  const auto sure = open({.only = {"Kitchens", "HALL"}});
  EXPECT_THAT(namesOf(*sure), ElementsAre("0.png", "1.png", "3.png"));
  EXPECT_THAT(sure->warnings(), IsEmpty()) << "it is the same name";
  const auto corrected = open({.split = "train", .only = {"hallway", "ofice"}});
  EXPECT_THAT(namesOf(*corrected), ElementsAre("0.png", "2.png"));
  EXPECT_EQ(corrected->warnings().size(), 2U);
  EXPECT_THAT(namesOf(*open({.only = {"kichen", "kitchen"}})), ElementsAre("3.png")) << "once";
  EXPECT_THAT(refusal({.only = {"corridor"}}), FailsWith(ErrorCode::unknownName));
}

TEST_F(Splits, UnknownOnesAreRefused) {
  EXPECT_THAT(refusal({.split = "valid"}), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT(refusal({.only = {"hall", "attic"}}), FailsWith(ErrorCode::unknownName));
  EXPECT_THAT(refusal({.split = "train", .only = {"kitchen"}}), FailsWith(ErrorCode::insufficientData));
  std::filesystem::remove(folder_ / "rooms.csv");
  EXPECT_THAT(refusal({.split = "train"}), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT(refusal({.only = {"hall"}}), FailsWith(ErrorCode::insufficientData));
}

class Nyu : public test::SequenceFolder {
 protected:
  void SetUp() override {
    for (const int i : {7, 8, 10, 100}) {
      write(fmt::format("rgb/{:04}.jpg", i), encoded(".jpg", test::texture(8, 6)));
      write(fmt::format("depth/{:04}.png", i),
            encoded(".png", cv::Mat(6, 8, CV_8U, cv::Scalar(i == 7 ? 255 : 51))));
    }
    write("scenes.csv",
          "index,split,scene,label_source\n7,test,kitchen,official\n8,train,office,block\n"
          "100,train,\"home, office\",block\n");
  }
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
  EXPECT_THAT(namesOf(*open({.split = "train"})), ElementsAre("0008.jpg", "0100.jpg"));
  EXPECT_EQ(open({.split = "test"})->depth(0).at<float>(0, 0), 10);
}

TEST_F(Nyu, RefusesAWrongTable) {
  for (const char* text :
       {"index,scene\n7,kitchen\n8\n", "index,scene\nseven,kitchen\n",
        "index,scene\n99999999999999999999,kitchen\n", "index,scene\n7,kitchen\n0007,hall\n"}) {
    write("scenes.csv", text);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile)) << text;
  }
  write("scenes.csv", "number,scene\n7,kitchen\n");
  EXPECT_THAT(refusal({.type = "nyu"}), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(roomsOf(*open()), ElementsAre("", "", "", "")) << "no NYU without its table";
  write("scenes.csv", "index,scene\n7,kitchen\n9,hall\n");
  EXPECT_THAT(open()->warnings(), ElementsAre(Mentions({"1 of 2"})));
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

class Vidrilo : public test::SequenceFolder {
 protected:
  void images(const std::string& pattern, const std::vector<int>& numbers) {
    for (const int n : numbers) add(fmt::format(fmt::runtime(pattern), n), n);
  }
  void clouds(const std::string& pattern, const std::vector<int>& numbers) {
    for (const int n : numbers) write(fmt::format(fmt::runtime(pattern), n), cloudAt(static_cast<float>(n)));
  }
  void asPublished() {
    images("Visual/sequence1visual{}.png", {1, 2, 10});
    clouds("Depth/sequence1depth{}.pcd", {1, 2, 10});
  }
  std::vector<std::string> rooms() { return roomsOf(*open()); }
};

TEST_F(Vidrilo, PairsImagesAndCloudsByNumberAndFindsTheirCamera) {
  asPublished();
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 3U);
  EXPECT_EQ(sequence->frame(2).name, "sequence1visual10.png");
  EXPECT_EQ(sequence->image(2).at<cv::Vec3b>(0, 0)[0], 10);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  ASSERT_TRUE(sequence->hasDepth());
  const cv::Mat depth = sequence->depth(2);
  ASSERT_EQ(depth.size(), cv::Size(16, 12));
  EXPECT_FLOAT_EQ(depth.at<float>(5, 4), 10.04F);
  EXPECT_EQ(depth.at<float>(2, 3), 0);
  EXPECT_THAT(sequence->intrinsics(), Optional(FieldsAre(16, 12, DoubleNear(20, 1e-3), DoubleNear(22, 1e-3),
                                                         DoubleNear(7, 1e-3), DoubleNear(5.5, 1e-3))));
}

TEST_F(Vidrilo, FindsNoCameraInCloudsThatAreNotSeenByOne) {
  for (const auto& [from, to] : {std::pair("WIDTH 16\nHEIGHT 12", "WIDTH 192\nHEIGHT 1"),
                                 {"x y z", "y x z"},
                                 {"x y z", "z y x"},
                                 {"x y z", "x z y"}}) {
    images("Visual/v{}.png", {1, 2});
    std::string cloud = cloudAt(1);
    cloud.replace(cloud.find(from), std::string(from).size(), to);
    for (const char* name : {"Depth/d1.pcd", "Depth/d2.pcd"}) write(name, cloud);
    EXPECT_FALSE(open()->intrinsics()) << to;
    EXPECT_EQ(test::caught([&] { open()->depth(0); }).code.has_value(), from[0] == 'W') << to;
    EXPECT_THAT(open()->warnings(), ::testing::SizeIs(1)) << to;
  }
}

TEST_F(Vidrilo, IsFoundByItsNamesAmongOtherFiles) {
  images("drive/rgb/{}.png", {1, 2});
  images("drive/mask/{}.png", {1, 2});
  clouds("drive/scans/{}.pcd", {1, 2});
  const auto found = [&] { return roomsOf(*openSequence(folder_ / "drive")); };
  write("drive.csv", "Hall\nOffice\n");
  EXPECT_THAT(found(), ElementsAre("Hall", "Office")) << "a table beside the folder";
  write("drive/labels.txt", "Kitchen\nToilet\n");
  write("drive/notes.txt", "on a sunny day");
  EXPECT_THAT(found(), ElementsAre("Kitchen", "Toilet")) << "the one whose name says so";
  images("drive/colors/{}.png", {1, 2});
  EXPECT_THAT([&] { openSequence(folder_ / "drive"); }, FailsWith(ErrorCode::unsupportedFile))
      << "two folders";
}

TEST_F(Vidrilo, ImagesAndCloudsOfOneFolderHaveItsNames) {
  for (const auto& [image, cloud, hasDepth] : {std::tuple("visual{}.png", "depth{}.pcd", true),
                                               {"photo{}.png", "depth{}.pcd", false},
                                               {"visual{}.png", "scan{}.pcd", false}}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      std::filesystem::remove(entry);
    images(image, {1, 2});
    clouds(cloud, {1, 2});
    EXPECT_EQ(open()->hasDepth(), hasDepth) << image << cloud;
  }
}

TEST_F(Vidrilo, ReadsAnnotationsInSeveralForms) {
  asPublished();
  EXPECT_THAT(rooms(), ElementsAre("", "", ""));
  write("annotations.txt", "Corridor 0 1\nToilet 1 0\nElevatorArea 0 0\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "ElevatorArea")) << "in the order of the images";
  write("annotations.txt", "10;Elevator Area;0;1\n1;\"Corridor\";1;1\n2;Toilet;0;0\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "Elevator Area")) << "by number";
  write("annotations.txt",
        "# of sequence 1\nsequence1visual2.png sequence1depth2.pcd 5 1\nsequence1visual1.png "
        "sequence1depth1.pcd 7 0\n");
  EXPECT_THAT(rooms(), ElementsAre("7", "5", "")) << "by file; categories may be numbers";
  write("annotations.txt", "x,y,Category,frame\n0.5,1,Corridor,1\n0.6,1,Toilet,2\n0.7,2,Hall,99\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "Toilet", "")) << "by a header";
  write("rooms.csv", "image,room\nsequence1visual1.png,Warehouse\n");
  EXPECT_THAT(rooms(), ElementsAre("Warehouse", "Toilet", "")) << "rooms.csv has the last word";
}

TEST_F(Vidrilo, ReadsPosesOfTheThesisAuthorsTables) {
  asPublished();
  write("Sequence1.txt", "Sequence 1\n10 2.5 -1 3.1 Toilet\n1 0.5 1 -0.25 Corridor\n");
  EXPECT_THAT(rooms(), ElementsAre("Corridor", "", "Toilet")) << "below a title: index x y theta category";
  auto sequence = open();
  ASSERT_TRUE(sequence->frame(0).pose);
  EXPECT_EQ(sequence->frame(0).pose->y, 1);
  EXPECT_NEAR(sequence->frame(0).pose->qz, Pose::planar(0.5, 1, -0.25).qz, 1e-12);
  EXPECT_FALSE(sequence->frame(1).pose);
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  write("Sequence1.txt", "Sequence 1\nindex category theta y x\n2 Hall 90 4 3\n");
  EXPECT_THAT(rooms(), ElementsAre("", "Hall", "")) << "names of columns below a title";
  write("Sequence1.txt", "index,category,theta,y,x\n2,Hall,90,4,3\n");
  sequence = open();
  EXPECT_EQ(sequence->frame(1).pose->x, 3);
  EXPECT_NEAR(sequence->frame(1).pose->qz, Pose::planar(3, 4, std::numbers::pi / 2).qz, 1e-12) << "degrees";
}

TEST_F(Vidrilo, TablesThatDoNotFitAreLeftOutWithAWarning) {
  asPublished();
  for (const char* table :
       {"Corridor 0\nToilet\nHall 1\n", "a.png\nb.png\nc.png\n", "0.5 1.5\n0.6 2.5\n0.7 1\n", "",
        "# none\n\n", "image,x,room\n1.png,Hall\n", "image,room\nsequence1visual1.png\n", "Corridor\nHall\n",
        "one\ntwo 2\nthree 3 3\n"}) {
    write("annotations.txt", table);
    EXPECT_THAT(rooms(), ElementsAre("", "", "")) << table;
    EXPECT_EQ(open()->warnings().size(), 1U) << table;
  }
}

TEST_F(Vidrilo, FoldersThatAreNoneAreRefused) {
  images("Visual/a{}.png", {1, 2});
  EXPECT_THAT(refusal({.type = "vidrilo"}), FailsWith(ErrorCode::unsupportedFile)) << "no clouds";
  clouds("Depth/b{}.pcd", {7});
  EXPECT_THAT(refusal({.type = "vidrilo"}), FailsWith(ErrorCode::mismatch)) << "no number in common";
  clouds("Depth/b{}.pcd", {1});
  EXPECT_THAT(open({.type = "vidrilo"})->warnings(), ::testing::SizeIs(1)) << "one image has no cloud";
  images("Visual/c{}.png", {1});
  EXPECT_THAT(refusal({.type = "vidrilo"}), FailsWith(ErrorCode::malformedFile)) << "two have the number 1";
}

TEST_F(Vidrilo, ADamagedCloudSpoilsItsOwnFrameOnly) {
  asPublished();
  write("Depth/sequence1depth1.pcd", cloudAt(1).substr(0, 500));
  const auto sequence = open();
  EXPECT_TRUE(sequence->intrinsics());
  EXPECT_THAT([&] { sequence->depth(0); }, FailsWith(ErrorCode::truncatedFile));
  EXPECT_FALSE(sequence->depth(1).empty());
}

TEST_F(SevenScenes, NamesTheWrongLineOfThePoseTable) {
  add("frames/frame-000005.color.jpg");
  const std::string header = "frame,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n";
  write("poses.csv", header + "5,1,0,0,4,0,1,0,5,0,0,1,6\n");
  EXPECT_EQ(open()->frame(0).pose->z, 6);
  for (const char* wrong : {"5,1,0,0,4,0,1\n", "5,1,0,0,4,0,1,0,5,0,0,1,6\nsix,1,0,0,4,0,1,0,5,0,0,1,6\n"}) {
    write("poses.csv", header + wrong);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile)) << wrong;
  }
}

TEST_F(SevenScenes, APhotographOfThatNameMakesNoDataSet) {
  for (const char* name : {"frame-000005.color.jpg", "kitchen.jpg", "hall.png"}) add(name);
  EXPECT_EQ(open()->size(), 3U);
}

}  // namespace
}  // namespace estancia
