// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/sequences/listed_sequence.hpp"
#include "estancia/sequences/trajectory.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::Mentions;
using ::testing::ElementsAre;

class TrajectoryFile : public ::testing::Test {
 protected:
  Trajectory read(const std::string& text) {
    test::writeFile(folder_ / "poses.txt", text);
    return readTrajectory(folder_ / "poses.txt");
  }
  test::ScratchFolder folder_;
};

std::array<double, 12> matrixOf(const Pose& pose) {
  std::array<double, 12> rows{};
  std::copy_n(rigidOf(pose).matrix.val, rows.size(), rows.begin());
  return rows;
}

Pose randomPose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Pose pose{1e3 * normal(random), normal(random), 1e-6 * normal(random), normal(random),
            normal(random),       normal(random), normal(random)};
  const double norm = std::hypot(std::hypot(pose.qx, pose.qy), std::hypot(pose.qz, pose.qw));
  for (double* q : {&pose.qx, &pose.qy, &pose.qz, &pose.qw}) *q /= norm;
  return pose;
}

void expectSame(const Pose& a, const Pose& b, double tolerance) {
  EXPECT_LE(distanceBetween(a, b), tolerance);
  const double dot = a.qx * b.qx + a.qy * b.qy + a.qz * b.qz + a.qw * b.qw;  // q and −q are the same rotation
  EXPECT_NEAR(std::abs(dot), 1, tolerance);
}

TEST_F(TrajectoryFile, ComesBackAsItWasWritten) {
  std::mt19937 random(1);
  std::vector<TrajectoryPoint> points;
  points.reserve(500);
  for (int i = 0; i < 500; ++i) points.push_back({1311868164.363181 + i / 29.97, randomPose(random)});
  writeTrajectory(points, folder_ / "t.txt");
  const Trajectory again = readTrajectory(folder_ / "t.txt");
  EXPECT_THAT(again.warnings, testing::IsEmpty());
  ASSERT_EQ(again.points.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(again.points[i].timestamp, points[i].timestamp);
    expectSame(*again.points[i].pose, *points[i].pose, 1e-12);
  }
}

TEST_F(TrajectoryFile, IsNotWrittenHalf) {
  EXPECT_THAT([&] { writeTrajectory({}, folder_ / "none" / "t.txt"); }, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_THAT(
      [&] {
        writeTrajectory({{1.0, Pose()}, {std::nullopt, Pose()}}, folder_ / "t.txt");
      },
      FailsWith(ErrorCode::invalidInput));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "t.txt"));
}

TEST_F(TrajectoryFile, TakesCommentsTabsAndAnyLengthOfQuaternion) {
  const auto trajectory =
      read("# t x y z qx qy qz qw\n\n1.5 1 2 3\t0 0 0 2 # double length\r\n2.5 -1e-3 2 3 0 0 5e-1 0\n");
  ASSERT_EQ(trajectory.points.size(), 2U);
  EXPECT_EQ(trajectory.points[0].timestamp, 1.5);
  EXPECT_EQ(trajectory.points[0].pose->qw, 1);
  EXPECT_EQ(trajectory.points[1].pose->qz, 1);
  EXPECT_EQ(trajectory.points[1].pose->x, -1e-3);
}

TEST_F(TrajectoryFile, LeavesOutPosesThatAreNoneAndSaysWhere) {
  const auto trajectory = read(
      "1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n3 0 0 0 0 0 0 0\n4 0 inf 0 0 0 0 1\nnan 0 0 0 0 0 0 1\n"
      "6 0 0 1e308 0 0 0 1\n");
  ASSERT_EQ(trajectory.points.size(), 6U);
  EXPECT_TRUE(trajectory.points[0].pose);
  for (std::size_t i : {1U, 2U, 3U, 5U}) EXPECT_FALSE(trajectory.points[i].pose) << i;
  EXPECT_FALSE(trajectory.points[4].timestamp);
  EXPECT_THAT(trajectory.warnings, ElementsAre(Mentions({"5 of 6", "line 2"})));
}

TEST_F(TrajectoryFile, NormalizesQuaternionsAndWarnsOfOddOnes) {
  const auto trajectory = read("1 0 0 0 0 0 0 1.001\n2 0 0 0 0 3 0 4\n");
  EXPECT_THAT(trajectory.warnings, ElementsAre(Mentions({"1 of 2", "line 2"})));
  EXPECT_DOUBLE_EQ(trajectory.points[1].pose->qy, 0.6);
  EXPECT_DOUBLE_EQ(trajectory.points[0].pose->qw, 1);
}

TEST_F(TrajectoryFile, RefusesLinesThatAreNoPoses) {
  EXPECT_THAT([&] { read("1 0 0 0 0 0 0 1\n2 0 0 0\n"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { read("kitchen.jpg 0 0 0 0 0 0 1\n"); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { read("# nothing\n"); }, FailsWith(ErrorCode::insufficientData));
}

TEST_F(TrajectoryFile, ReadsKittiMatrices) {
  std::mt19937 random(2);
  std::string text;
  std::vector<Pose> poses;
  for (int i = 0; i < 200; ++i) {
    poses.push_back(randomPose(random));
    for (const double v : matrixOf(poses.back())) text += fmt::format("{:e} ", v);
    text += '\n';
  }
  text += "2 0 0 0  0 2 0 0  0 0 2 0\n";   // a scaling
  text += "-1 0 0 0  0 1 0 0  0 0 1 0\n";  // a mirror
  const auto trajectory = read(text);
  ASSERT_EQ(trajectory.points.size(), 202U);
  for (std::size_t i = 0; i < poses.size(); ++i) expectSame(*trajectory.points[i].pose, poses[i], 2e-3);
  EXPECT_FALSE(trajectory.points[200].pose || trajectory.points[201].pose);
  EXPECT_THAT(trajectory.warnings, ElementsAre(Mentions({"2 of 202"})));
}

TEST(PoseOfMatrix, InvertsTheMatrixOfAPoseAlsoAtHalfTurns) {
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    const Pose pose = randomPose(random);
    expectSame(io::poseOfMatrix(matrixOf(pose)).value(), pose, 1e-9);
  }
  for (const Pose& half : {Pose{0, 0, 0, 1, 0, 0, 0}, Pose{0, 0, 0, 0, 1, 0, 0}, Pose{0, 0, 0, 0, 0, 1, 0}})
    expectSame(io::poseOfMatrix(matrixOf(half)).value(), half, 1e-12);
}

TEST(PoseOfMatrix, GivesNothingForNanAndForNoPlaceOnTheEarth) {
  auto matrix = matrixOf(Pose());
  matrix[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(io::poseOfMatrix(matrix));
  matrix[7] = 1e8;  // farther than any place on the Earth
  EXPECT_FALSE(io::poseOfMatrix(matrix));
}

TEST_F(TrajectoryFile, OfFramesGoesByTheirTimesOrElseByOrderEvenWhenTheFirstIsLost) {
  std::vector<Frame> frames(4);
  for (std::size_t i = 1; i < frames.size(); ++i)
    frames[i].pose = Pose{.x = static_cast<double>(i), .y = 0.1};
  writePoses(frames, folder_ / "t.txt");
  auto written = readTrajectory(folder_ / "t.txt").points;
  ASSERT_EQ(written.size(), 4U);
  EXPECT_FALSE(written[0].pose);
  EXPECT_EQ(written[3].pose.value().x, 3);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].timestamp = 10 + static_cast<double>(i);
  writePoses(frames, folder_ / "t.txt");
  written = readTrajectory(folder_ / "t.txt").points;
  ASSERT_EQ(written.size(), 3U);
  EXPECT_EQ(written[0].timestamp, 11);
  EXPECT_EQ(written[0].pose.value().x, 1);
  EXPECT_THROW(writePoses(std::vector<Frame>(2), folder_ / "t.txt"), Error);
}

TEST_F(TrajectoryFile, WarnsOfDoubledAndUnorderedTimes) {
  const auto trajectory = read("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
  EXPECT_THAT(trajectory.warnings,
              ElementsAre(Mentions({"1 of 4", "line 2"}), Mentions({"1 of 4", "line 4"})));
}

}  // namespace
}  // namespace estancia
