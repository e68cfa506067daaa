// Videos, and tours of panoramas: frames that are computed when they are read.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "readers/sequence_folder.hpp"

namespace estancia {
namespace {

using test::FailsWith;

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

class Panorama : public test::SequenceFolder {
 protected:
  void add(const std::string& name, const cv::Mat& panorama) {
    write(name, test::encoded(name.substr(name.rfind('.')), panorama));
  }
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
  write("b.exr", exr.substr(0, exr.size() / 2));
  write("c.exr.js", "export default 'data:application/exr;base64,dj8x");
  write("d.exr.js", "export default 'data:application/exr;base64,!!!!'");
  write("e.exr.js", "export default 'data:application/exr;base64,di8xAQ=='");
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

constexpr int kFrames = 120;

/// The frame's number in binary: eight black or white bars, which no coding blurs away.
cv::Mat imageOf(int number) {
  cv::Mat image = test::plain(64, 48, {});
  for (int bit = 0; bit < 8; ++bit)
    if ((number >> bit & 1) != 0) image.colRange(8 * bit, 8 * bit + 8).setTo(cv::Scalar::all(255));
  return image;
}

int numberOf(const cv::Mat& image) {
  EXPECT_EQ(image.type(), CV_8UC3);
  EXPECT_EQ(image.size(), cv::Size(64, 48));
  int number = 0;
  for (int bit = 0; bit < 8; ++bit) number |= (image.at<cv::Vec3b>(24, 8 * bit + 4)[1] > 127) << bit;
  return number;
}

class Video : public ::testing::Test {
 protected:
  std::filesystem::path write(const char* c, const std::string& suffix) {
    const std::filesystem::path file = folder_ / ("drive" + suffix);
    cv::VideoWriter writer(file, cv::VideoWriter::fourcc(c[0], c[1], c[2], c[3]), 20, {64, 48});
    EXPECT_TRUE(writer.isOpened());
    for (int i = 0; i < kFrames; ++i) writer.write(imageOf(i));
    return file;
  }
  test::ScratchFolder folder_;
};

TEST_F(Video, GivesItsFramesInOrderWithTheirTimes) {
  for (const auto& file : {write("MJPG", ".avi"), write("mp4v", ".mp4")}) {
    const auto video = openSequence(file);
    ASSERT_EQ(video->size(), static_cast<std::size_t>(kFrames));
    EXPECT_EQ(video->name(), file.filename());
    EXPECT_EQ(video->frame(7).name, "frame 000007");
    EXPECT_DOUBLE_EQ(video->frame(7).timestamp.value(), 7 / 20.0);
    EXPECT_THAT(video->warnings(), testing::IsEmpty());
    for (int i = 0; i < kFrames; ++i) EXPECT_EQ(numberOf(video->image(static_cast<std::size_t>(i))), i);
  }
}

TEST_F(Video, SeeksToTheRightFrame) {
  for (const auto& file : {write("MJPG", ".avi"), write("mp4v", ".mp4")}) {
    const auto video = openSequence(file);
    for (const int i : {100, 3, 119, 0, 60, 59, 58, 118, 1, 1, 2})
      EXPECT_EQ(numberOf(video->image(static_cast<std::size_t>(i))), i);
  }
}

TEST_F(Video, MayBeReadFromSeveralThreads) {
  for (const auto& file : {write("MJPG", ".avi"), write("mp4v", ".mp4")}) {
    const auto video = openSequence(file);
    std::atomic<int> wrong = 0;
    test::inThreads(3, [&](int t) {
      for (int i = t; i < kFrames; i += 3)
        if (numberOf(video->image(static_cast<std::size_t>(i))) != i) ++wrong;
    });
    EXPECT_EQ(wrong, 0);
  }
}

TEST_F(Video, ListsOnlyWhatIsThereWhenItWasCut) {
  const std::string whole = test::readFile(write("MJPG", ".avi"));
  test::writeFile(folder_ / "cut.avi", whole.substr(0, whole.size() / 2));
  const auto video = openSequence(folder_ / "cut.avi");
  EXPECT_GT(video->size(), 40U);
  EXPECT_LT(video->size(), 80U);
  for (std::size_t i = 0; i + 1 < video->size(); ++i)
    EXPECT_EQ(numberOf(video->image(i)), static_cast<int>(i));
}

TEST_F(Video, DoesNotBelieveADeclaredNumberOfFrames) {
  const std::string whole = test::readFile(write("MJPG", ".avi"));
  const auto length = whole.find("vids") + 32;  // dwLength of the stream header
  const auto total = whole.find("avih") + 8 + 16;
  const auto sizeWith = [&](const std::string& lie) {
    std::string bytes = whole;
    bytes.replace(length, 4, lie);
    bytes.replace(total, 4, lie);
    test::writeFile(folder_ / "lie.avi", bytes);
    const auto video = openSequence(folder_ / "lie.avi");
    for (std::size_t i = 0; i < video->size(); ++i) EXPECT_EQ(numberOf(video->image(i)), static_cast<int>(i));
    return static_cast<int>(video->size());
  };
  EXPECT_EQ(sizeWith("\xFF\xFF\xFF\x7F"), kFrames);
  EXPECT_EQ(sizeWith(std::string(4, '\0')), kFrames);
  EXPECT_GE(sizeWith(std::string("\x05\0\0\0", 4)), 5)
      << "OpenCV itself stops there, but no frame may be missing";
}

TEST(NoVideo, IsRefusedWithASentence) {
  const test::ScratchFolder folder;
  for (const std::string& bytes :
       {std::string("Dear reader, this is text."), std::string(), std::string("no video\0\1\2", 11)}) {
    test::writeFile(folder / "a.mp4", bytes);
    EXPECT_THAT([&] { openSequence(folder / "a.mp4"); }, FailsWith(ErrorCode::unsupportedFile)) << bytes;
  }
  test::writeFile(folder / "c.PNG", test::encoded(".png", test::plain(4, 4, {})));
  EXPECT_EQ(openSequence(folder / "c.PNG")->frame(0).name, "c.PNG") << "a sequence of one image";
  SequenceOptions options;
  options.type = "video";
  EXPECT_TRUE(test::caught([&] { openSequence(folder.path(), options); }).code);
}

}  // namespace
}  // namespace estancia
