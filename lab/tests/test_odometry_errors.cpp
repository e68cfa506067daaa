// Odometry beside the truth, on a rendered table that a camera is moved around.
// SPDX-License-Identifier: Apache-2.0
#include "odometry/odometry_errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "color_drive.hpp"
#include "runner/experiment.hpp"
#include "support/errors.hpp"
#include "support/table_scene.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;

std::shared_ptr<const test::TableSequence> tableDrive(std::vector<double> degrees) {
  return std::make_shared<test::TableSequence>(
      std::vector{test::ballAt(0.1, 0, 0.06, test::red),
                  test::boxAt(-0.1, 0.1, {0.05, 0.08, 0.1}, test::blue)},
      degrees);
}

TEST(AlteredDrive, LeavesOutFrames) {
  const auto drive = tableDrive({0, 5, 10, 15, 20});
  const AlteredDrive altered(drive, {.every = 2});
  ASSERT_EQ(altered.size(), 3U);
  EXPECT_EQ(altered.frame(1).name, drive->frame(2).name);
  EXPECT_EQ(altered.frame(2).pose->x, drive->frame(4).pose->x);
  EXPECT_EQ(cv::norm(altered.depth(2), drive->depth(4)), 0) << "no noise where none is asked for";
  EXPECT_TRUE(altered.intrinsics());
  EXPECT_EQ(AlteredDrive(drive, {.every = 99}).size(), 1U);
}

TEST(AlteredDrive, AddsNoiseThatGrowsWithTheSquareOfDepth) {
  const auto drive = tableDrive({0, 5});
  const AlteredDrive noisy(drive, {1, 0.01, 0, 0, 3}), same(drive, {1, 0.01, 0, 0, 3}),
      other(drive, {1, 0.01, 0, 0, 4});
  const cv::Mat truth = drive->depth(1), depth = noisy.depth(1);
  double sum = 0, count = 0;
  for (int i = 0; i < static_cast<int>(truth.total()); ++i) {
    const double z = truth.ptr<float>()[i];
    if (z == 0) {
      ASSERT_EQ(depth.ptr<float>()[i], 0) << "unknown stays unknown";
      continue;
    }
    sum += std::pow((depth.ptr<float>()[i] - z) / (0.01 * z * z), 2);
    ++count;
  }
  EXPECT_NEAR(std::sqrt(sum / count), 1, 0.02);
  EXPECT_EQ(cv::norm(depth, same.depth(1)), 0);
  EXPECT_GT(cv::norm(depth, other.depth(1)), 0);
  EXPECT_THAT([&] { AlteredDrive(drive, {.every = 0}); }, FailsWith(ErrorCode::invalidOption));
}

TEST(AlteredDrive, WheelsErrAStepAtATime) {
  const auto drive = tableDrive({0, 5, 10, 15, 20, 25, 30, 35});
  EXPECT_TRUE(AlteredDrive(drive, {}).wheels().empty());
  const auto steps = [&](const std::vector<std::optional<Pose>>& poses) {
    std::vector<double> lengths;
    for (std::size_t i = 1; i < poses.size(); ++i)
      lengths.push_back(distanceBetween(*poses[i], *poses[i - 1]));
    return lengths;
  };
  const auto tiny = AlteredDrive(drive, {1, 0, 1e-9, 0, 1}).wheels();
  ASSERT_EQ(tiny.size(), drive->size());
  EXPECT_NEAR(distanceBetween(*tiny.front(), *tiny.back()),
              distanceBetween(*drive->frame(0).pose, *drive->frame(7).pose), 1e-6)
      << "the path as it is, from another origin";
  const AlteredDrive noisy(drive, {1, 0, 10, 2, 1});
  const auto lengths = steps(noisy.wheels()), again = steps(noisy.wheels()), right = steps(tiny);
  EXPECT_EQ(lengths, again);
  for (std::size_t i = 0; i < right.size(); ++i) EXPECT_NEAR(lengths[i], right[i], 0.4 * right[i]);
  EXPECT_NE(lengths, right);
  EXPECT_EQ(AlteredDrive(drive, {3, 0, 10, 2, 1}).wheels().size(), 3U);
}

class OdometryErrors : public testing::Test {
 protected:
  void SetUp() override {
    test::writeColorModel(scratch_, "sharp", "0.02");
    tableDrive({0, 3, 6, 9, 12, 15})->writeTo(scratch_ / "table");
  }

  const std::string drive_ = "[[drive]]\nname = \"table\"\npath = \"table\"\n";

  Findings run(const std::string& text) {
    writeFile(scratch_ / "track.toml", "type = \"odometry\"\n" + text);
    return runExperiment({scratch_ / "track.toml"},
                         {scratch_ / "out", {scratch_ / "sharp"}, {"", 1}, nullptr}, progress_);
  }
  test::Caught problem(const std::string& text) {
    return test::caught([&] { run(text); });
  }

  test::ScratchFolder scratch_;
  Progress progress_;
};

TEST_F(OdometryErrors, AreMeasuredForEveryVariant) {
  const std::string text = drive_ +
                           "[[variant]]\nname = \"plain\"\n[[variant]]\nname = \"half\"\nevery = 2\n"
                           "[[variant]]\nname = \"noise\"\nnoise = 0.0012\n"
                           "[[variant]]\nname = \"wheels\"\nwheel_shift = 3\nwheel_turn = 2\n";
  const Findings found = run(text);
  ASSERT_EQ(found.sections.size(), 1U);
  const auto& table = std::get<ResultTable>(found.sections[0]);
  ASSERT_EQ(table.rows.size(), 4U);
  EXPECT_EQ(table.rows[0].values[0], 6) << "frames";
  EXPECT_EQ(table.rows[1].values[0], 3) << "frames";
  EXPECT_EQ(table.columns[6].name, "RMSE [m]");
  EXPECT_LT(table.rows[0].values[6], 0.05) << "a path of a quarter of a meter";
  EXPECT_NE(table.rows[0].values[6], table.rows[2].values[6]);
  const std::string before = readFile(scratch_ / "out/results.csv");
  std::filesystem::remove_all(scratch_ / "out");
  run(text);
  EXPECT_EQ(readFile(scratch_ / "out/results.csv"), before) << "noise has a seed";
}

TEST_F(OdometryErrors, SayWhatIsWrongAndWhere) {
  EXPECT_THAT(problem("[[variant]]\nname = \"a\"\n"), FailsWith(ErrorCode::malformedFile, "`drive`"));
  EXPECT_THAT(problem(drive_ + "[[variant]]\nname = \"a\"\n[[variant]]\nname = \"a\"\n"),
              FailsWith(ErrorCode::malformedFile, "track.toml:"));
  EXPECT_THAT(problem(drive_ + "[[variant]]\nname = \"a\"\nevery = 0\n"),
              FailsWith(ErrorCode::malformedFile, "every"));
  EXPECT_THAT(problem(drive_ + "[[variant]]\nname = \"a\"\nnoise = -1\n"),
              FailsWith(ErrorCode::malformedFile, "noise"));
  std::filesystem::remove(scratch_ / "table/poses.txt");
  EXPECT_THAT(problem(drive_), FailsWith(ErrorCode::insufficientData, "table"));
}

}  // namespace
}  // namespace estancia::experiments
