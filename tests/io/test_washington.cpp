// The RGB-D Object Dataset on made-up folders of its published layout.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "estancia/io/object_views.hpp"
#include "io/images.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::encoded;
using test::FailsWith;
using test::Mentions;
using test::writeFile;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class Washington : public ::testing::Test {
 protected:
  /// 20 × 10 pixels that begin in column 101 and row 201 (from 1); the thing fills all but the first 2
  /// columns, 1.5 m away, except for a hole.
  void view(const std::string& stem, const std::string& place = "101,201\n", int depthType = CV_16U) {
    cv::Mat mask(10, 20, CV_8U, cv::Scalar(255)), depth(10, 20, depthType, cv::Scalar(1500));
    mask({0, 0, 2, 10}).setTo(0);
    depth({2, 0, 1, 1}).setTo(0);
    write(stem + "_crop.png", encoded(".png", test::plain(20, 10, {1, 2, 3})));
    write(stem + "_depthcrop.png", encoded(".png", depth));
    write(stem + "_maskcrop.png", encoded(".png", mask));
    write(stem + "_loc.txt", place);
  }
  void write(const std::string& name, const std::string& bytes) { writeFile(folder_ / name, bytes); }
  std::unique_ptr<ObjectViews> open(const std::string& type = "auto") {
    ObjectViewsOptions options;
    options.type = type;
    return openObjectViews(folder_.path(), options);
  }
  static std::vector<std::string> namesOf(const ObjectViews& views) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < views.size(); ++i) names.push_back(views.view(i).name);
    return names;
  }
  test::ScratchFolder folder_;
};

TEST_F(Washington, NamesAreReadFromTheRight) {
  view("bell_pepper/bell_pepper_1/bell_pepper_1_2_37");
  view("bell_pepper/bell_pepper_1/bell_pepper_1_2_9");
  view("bell_pepper/bell_pepper_12/bell_pepper_12_1_1");
  view("apple/apple_3/apple_3_4_1");
  view("apple/apple_3/apple_3_1");    // no video
  view("apple/apple_3/apple_1_4_1");  // of another thing
  view("apple/pear_1/pear_1_1_1");    // in another category
  view("apple/apple_x/apple_x_1_1");  // no number
  write("README.txt", "words");
  const auto views = open();
  EXPECT_THAT(namesOf(*views),
              ElementsAre("apple_3_4_1", "bell_pepper_1_2_9", "bell_pepper_1_2_37", "bell_pepper_12_1_1"));
  EXPECT_EQ(views->view(2).instance, "bell_pepper_1");
  EXPECT_EQ(views->view(2).category, "bell_pepper");
  EXPECT_EQ(views->view(2).frame, "bell_pepper_1_2_37");
  EXPECT_THAT(views->warnings(), IsEmpty());
}

TEST_F(Washington, PointsAreMetricInTheWholeImage) {
  view("mug/mug_1/mug_1_1_1");
  view("mug/mug_1/mug_1_1_2", "1 1");
  const auto views = open();
  const PointCloud cloud = views->cloud(0);
  ASSERT_EQ(cloud.points.size(), 18U * 10U - 1U);
  EXPECT_FLOAT_EQ(cloud.points[0].z, 1.5F);  // column 103, counted from 0, of row 200
  EXPECT_NEAR(cloud.points[0].x, (103 - 320) / 570.3 * 1.5, 1e-6);
  EXPECT_NEAR(cloud.points[0].y, (200 - 240) / 570.3 * 1.5, 1e-6);
  EXPECT_EQ(cloud.colors[0], cv::Vec3b(1, 2, 3));
  EXPECT_NEAR(views->cloud(1).points[0].x, (3 - 320) / 570.3 * 1.5, 1e-6);
  const ObjectImage seen = views->image(0);
  EXPECT_EQ(seen.image.size(), cv::Size(20, 10));
  EXPECT_EQ(seen.box, cv::Rect(2, 0, 18, 10));
  EXPECT_EQ(cv::countNonZero(seen.mask), 180);
}

TEST_F(Washington, TheCameraMayBeTold) {
  view("mug/mug_1/mug_1_1_1");
  write("camera-intrinsics.txt", "500 510 300 200\n");
  EXPECT_NEAR(open()->cloud(0).points[0].x, (103 - 300) / 500.0 * 1.5, 1e-6);
  write("camera-intrinsics.txt", "a camera\n");
  EXPECT_THAT([&] { open(); }, FailsWith(ErrorCode::malformedFile));
}

TEST_F(Washington, IncompleteViewsAreLeftOut) {
  for (const char* stem :
       {"mug/mug_1/mug_1_1_1", "mug/mug_1/mug_1_1_2", "mug/mug_1/mug_1_1_3", "mug/mug_1/mug_1_1_4"})
    view(stem);
  fs::remove(folder_ / "mug/mug_1/mug_1_1_1_maskcrop.png");
  fs::remove(folder_ / "mug/mug_1/mug_1_1_2_loc.txt");
  fs::remove(folder_ / "mug/mug_1/mug_1_1_3_depthcrop.png");
  const auto views = open();
  EXPECT_THAT(namesOf(*views), ElementsAre("mug_1_1_4"));
  EXPECT_THAT(views->warnings(), ElementsAre(Mentions({"3 of 4", "mug_1_1_1_maskcrop.png"})));
  fs::remove(folder_ / "mug/mug_1/mug_1_1_4_loc.txt");
  EXPECT_THAT([&] { open(); }, FailsWith(ErrorCode::insufficientData));
}

TEST_F(Washington, WrongPlacesAreRefused) {
  const auto refusal = [&](const char* place) {
    view("mug/mug_1/mug_1_1_1", place);
    return test::caught([&] { open()->cloud(0); });
  };
  for (const char* place : {"", "1", "1,2,3", "x,y", "0,1", "-5,3", "nan,1", "1e9,1"})
    EXPECT_THAT(refusal(place), FailsWith(ErrorCode::malformedFile)) << place;
  for (const char* place : {"630,1", "1,480"})
    EXPECT_THAT(refusal(place), FailsWith(ErrorCode::mismatch)) << place;
}

TEST_F(Washington, ImagesThatDoNotFitAreRefused) {
  const std::string stem = "mug/mug_1/mug_1_1_1";
  view(stem);
  const auto views = open();
  write(stem + "_maskcrop.png", encoded(".png", cv::Mat(9, 20, CV_8U, cv::Scalar(1))));
  EXPECT_THAT([&] { views->image(0); }, FailsWith(ErrorCode::mismatch));
  view(stem);
  write(stem + "_depthcrop.png", encoded(".png", cv::Mat::zeros(10, 20, CV_16U)));
  EXPECT_THAT([&] { views->cloud(0); }, FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia
