// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "estancia/readers/open_sequence.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::encoded;
using test::FailsWith;
using ::testing::IsEmpty;

constexpr double degree = std::numbers::pi / 180;

/// A gray world with one red spot in direction (`heading` counter-clockwise from the center, `elevation` up)
/// [degrees].
cv::Mat worldWithSpot(double heading, double elevation) {
  cv::Mat world(512, 1024, CV_32FC3, cv::Scalar::all(1));
  const double column = std::fmod((0.5 - heading / 360) * world.cols + world.cols, world.cols);
  const double row = (0.5 - elevation / 180) * world.rows;
  for (int shift : {-world.cols, 0, world.cols})  // a spot on the seam is on both edges
    cv::circle(world, cv::Point2d(column - 0.5 + shift, row - 0.5), 6, cv::Scalar(0.01, 0.01, 4), cv::FILLED);
  return world;
}

/// Where the spot is [pixels], nothing when it is not to be seen.
std::optional<cv::Point2d> findSpot(const cv::Mat& view) {
  cv::Mat channels[3];
  cv::split(view, channels);
  const cv::Mat red = channels[2] - channels[0] > 100;
  const cv::Moments m = cv::moments(red, true);
  if (m.m00 < 3) return std::nullopt;
  return cv::Point2d(m.m10 / m.m00 + 0.5, m.m01 / m.m00 + 0.5);
}

class Panorama : public ::testing::Test {
 protected:
  void add(const std::string& name, const cv::Mat& panorama) {
    test::writeFile(folder_ / name, encoded(name.substr(name.rfind('.')), panorama));
  }
  std::unique_ptr<Sequence> open() { return openSequence(folder_.path(), options_); }

  test::ScratchFolder folder_;
  SequenceOptions options_;
};

TEST_F(Panorama, ShowsThingsWhereTheyAre) {
  const double focal = 160 / std::tan(40 * degree);
  for (const double spot : {0.0, 75.0, 180.0, 250.0}) {
    add("world.exr", worldWithSpot(spot, 12));
    for (const double turnedLeft : {-30.0, -5.0, 0.0, 20.0, 33.0}) {
      options_.views = 1;
      options_.turn = spot + turnedLeft;
      const auto view = open();
      const auto seen = findSpot(view->image(0));
      ASSERT_TRUE(seen) << spot << " " << turnedLeft;
      // Turning to the left moves things to the right; what is above the horizon is in the upper half.
      EXPECT_NEAR(seen->x, 160 + focal * std::tan(turnedLeft * degree), 1.5) << spot << " " << turnedLeft;
      EXPECT_NEAR(seen->y, 120 - focal * std::tan(12 * degree) / std::cos(turnedLeft * degree), 1.5);
      // The pose agrees: it looks along the heading, in the map's counter-clockwise sense.
      const auto forward = view->frame(0).pose->forward();
      EXPECT_NEAR(forward[0], std::cos(options_.turn * degree), 1e-9);
      EXPECT_NEAR(forward[1], std::sin(options_.turn * degree), 1e-9);
    }
    options_.turn = spot + 60;
    EXPECT_FALSE(findSpot(open()->image(0))) << "out of sight";
  }
}

TEST_F(Panorama, ListsEveryViewOfEveryPlaceInEveryRound) {
  for (const char* name : {"lab.exr", "hall 10.exr", "hall 9.exr"})
    add(name, cv::Mat(8, 16, CV_32FC3, cv::Scalar::all(1)));
  options_.views = 4;
  options_.turn = -7;
  options_.rounds = 2;
  const auto tour = open();
  ASSERT_EQ(tour->size(), 24U);
  EXPECT_EQ(tour->frame(0).name, "hall 9/r1_h353");
  EXPECT_EQ(tour->frame(1).name, "hall 9/r1_h083");
  EXPECT_EQ(tour->frame(4).room, "hall 10");
  EXPECT_EQ(tour->frame(8).room, "lab");
  EXPECT_EQ(tour->frame(12).room, "hall 9");
  EXPECT_NE(tour->frame(12).name.substr(9), tour->frame(0).name.substr(9))
      << "the second round looks elsewhere";
  EXPECT_EQ(tour->frame(23).timestamp, 23.0);
  const auto step = [&](std::size_t a, std::size_t b) {
    return distanceBetween(*tour->frame(a).pose, *tour->frame(b).pose);
  };
  EXPECT_EQ(step(0, 3), 0);
  EXPECT_NEAR(step(3, 4), 4, 1e-9);
  EXPECT_NEAR(step(4, 8), 4, 1e-9);
  EXPECT_NEAR(step(8, 0), 4, 1e-9);
  EXPECT_EQ(step(0, 12), 0);
}

TEST_F(Panorama, ExposesTheLogAverageToMiddleGrayAndChangesItByStops) {
  const auto grayOf = [&](double radiance, double exposure) {
    add("a.exr", cv::Mat(64, 128, CV_32FC3, cv::Scalar::all(radiance)));
    options_.exposure = exposure;
    return static_cast<int>(open()->image(0).at<cv::Vec3b>(120, 160)[1]);
  };
  EXPECT_EQ(grayOf(5, 0), 118);  // 0.18 in sRGB
  EXPECT_EQ(grayOf(5e-3, 0), 118);
  EXPECT_EQ(grayOf(5e3, 0), 118);
  EXPECT_EQ(grayOf(5, -1), 85);  // 0.09
  EXPECT_EQ(grayOf(5, 1), 162);  // 0.36
  EXPECT_GT(grayOf(5, 3), grayOf(5, 2)) << "highlights keep their differences";
  EXPECT_EQ(grayOf(0, 0), 0);
}

TEST_F(Panorama, ReadsImagesOnlyWhenAskedForAndLeavesTheirExposure) {
  add("a.png", test::plain(512, 256, {40, 80, 160}));
  EXPECT_EQ(open()->size(), 1U) << "an ordinary image";
  options_.type = "panorama";
  const auto tour = open();
  ASSERT_EQ(tour->size(), 12U);
  EXPECT_EQ(tour->image(5).at<cv::Vec3b>(100, 100), cv::Vec3b(40, 80, 160));
  options_.exposure = -1;
  EXPECT_LT(open()->image(5).at<cv::Vec3b>(100, 100)[2], 130);
}

TEST_F(Panorama, FailsFrameByFrameWhereOneIsDamaged) {
  add("a.exr", cv::Mat(8, 16, CV_32FC3, cv::Scalar::all(1)));
  const std::string exr = test::readFile(folder_ / "a.exr");
  test::writeFile(folder_ / "b.exr", exr.substr(0, exr.size() / 2));
  test::writeFile(folder_ / "c.exr.js", "export default 'data:application/exr;base64,dj8x");
  test::writeFile(folder_ / "d.exr.js", "export default 'data:application/exr;base64,!!!!'");
  test::writeFile(folder_ / "e.exr.js", "export default 'data:application/exr;base64,di8xAQ=='");
  add("f.exr", cv::Mat(8, 8, CV_32FC3, cv::Scalar::all(1)));
  options_.views = 1;
  const auto tour = open();
  ASSERT_EQ(tour->size(), 6U);
  EXPECT_EQ(tour->image(0).size(), cv::Size(320, 240));
  EXPECT_TRUE(test::caught([&] { tour->image(1); }).code);
  EXPECT_THAT([&] { tour->image(2); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { tour->image(3); }, FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { tour->image(4); }, FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT([&] { tour->image(5); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(Panorama, RefusesImpossibleTours) {
  add("a.exr", cv::Mat(8, 16, CV_32FC3, cv::Scalar::all(1)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<SequenceOptions> wrong(6);
  wrong[0].views = 0;
  wrong[1].views = 100000;
  wrong[2].fieldOfView = 180;
  wrong[3].rounds = 0;
  wrong[4].exposure = nan;
  wrong[5].turn = nan;
  for (const SequenceOptions& options : wrong)
    EXPECT_THAT([&] { openSequence(folder_.path(), options); }, FailsWith(ErrorCode::invalidOption));
}

}  // namespace
}  // namespace estancia
