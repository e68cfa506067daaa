// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/files.hpp"
#include "estancia/sequences/listed_sequence.hpp"
#include "estancia/sequences/trajectory.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::Mentions;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class TrajectoryFile : public ::testing::Test {
 protected:
  Trajectory read(const std::string& text) {
    test::writeFile(folder_ / "poses.txt", text);
    return readTrajectory(folder_ / "poses.txt");
  }
  test::ScratchFolder folder_;
};

std::array<double, 12> matrixOf(const Pose& p) {
  const double x = p.qx, y = p.qy, z = p.qz, w = p.qw;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),     p.x,
          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),     p.y,
          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y), p.z};
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
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
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
  EXPECT_THAT(again.warnings, IsEmpty());
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

std::vector<Frame> frames(bool stamped) {
  std::vector<Frame> result(4);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].name = "frame " + std::to_string(i);
    if (stamped) result[i].timestamp = 10 + static_cast<double>(i);
    if (i != 0) result[i].pose = Pose{.x = static_cast<double>(i), .y = 0.1};
  }
  return result;
}

TEST(WrittenPoses, GoByTimeWhereFramesHaveStamps) {
  const test::ScratchFolder folder;
  writePoses(frames(true), folder / "t.txt");
  const auto read = readTrajectory(folder / "t.txt");
  ASSERT_EQ(read.points.size(), 3U);
  EXPECT_EQ(read.points[0].timestamp, 11);
  EXPECT_EQ(read.points[0].pose->x, 1);
}

TEST(WrittenPoses, GoByOrderOtherwiseEvenWhenTheFirstIsLost) {
  const test::ScratchFolder folder;
  writePoses(frames(false), folder / "t.txt");
  const auto read = readTrajectory(folder / "t.txt");
  ASSERT_EQ(read.points.size(), 4U);
  EXPECT_FALSE(read.points[0].pose);
  ASSERT_TRUE(read.points[3].pose);
  EXPECT_EQ(read.points[3].pose->x, 3);
}

TEST(WrittenPoses, NoPoseAtAllIsRefused) {
  const test::ScratchFolder folder;
  EXPECT_THROW(writePoses(std::vector<Frame>(2), folder / "t.txt"), Error);
}

TEST_F(TrajectoryFile, WarnsOfDoubledAndUnorderedTimes) {
  const auto trajectory = read("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
  EXPECT_THAT(trajectory.warnings,
              ElementsAre(Mentions({"1 of 4", "line 2"}), Mentions({"1 of 4", "line 4"})));
}

}  // namespace
}  // namespace estancia
