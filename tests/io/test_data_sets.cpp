// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estancia/io/csv.hpp"
#include "estancia/io/files.hpp"
#include "estancia/io/sequence.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::Mentions;
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

TEST(Idol2, RefusesOtherNamesWhenAskedFor) {
  const test::ScratchFolder folder;
  for (const char* name :
       {"t1_rPA_x1_y2.png", "t1_r_x1_y2_a3.png", "tx_rPA_x1_y2_a3.png", "t1_rPA_x1_y2_a3_z4.png"})
    test::writeFile(folder / name, tinyPng());
  SequenceOptions options;
  options.type = "idol2";
  EXPECT_THAT([&] { openSequence(folder.path(), options); }, FailsWith(ErrorCode::insufficientData));
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

TEST(SevenScenes, ReadsTheRedKitchen) {
  const auto data = test::findData("sevenscenes_redkitchen");
  ESTANCIA_NEEDS(data, "the real data set sevenscenes_redkitchen is missing");
  const auto sequence = openSequence(*data);
  ASSERT_EQ(sequence->size(), 200U);
  EXPECT_EQ(sequence->frame(199).name, "frame-000995.color.jpg");
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  const Pose pose = sequence->frame(0).pose.value();  // the first line of poses.csv
  EXPECT_EQ(pose.x, -0.3404563);
  EXPECT_EQ(pose.y, 0.01646982);
  EXPECT_EQ(pose.z, 0.2965692);
  EXPECT_NEAR(pose.forward()[0], -0.3142243, 1e-4);
  EXPECT_NEAR(pose.forward()[1], 0.04527963, 1e-4);
  EXPECT_NEAR(pose.forward()[2], 0.9482093, 1e-4);
  EXPECT_EQ(sequence->image(199).size(), cv::Size(640, 480));
}

}  // namespace
}  // namespace estancia
