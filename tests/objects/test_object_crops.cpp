// Views of objects as a sequence of images.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/object_crops.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using ::testing::ElementsAre;

/// A view with an image, one with a cloud alone, and one that cannot be read.
class Three final : public ObjectViews {
 public:
  Three() { warnings_ = {"one is odd"}; }
  std::string name() const override { return "three"; }
  std::size_t size() const override { return views_.size(); }
  const ObjectView& view(std::size_t i) const override { return views_[i]; }
  PointCloud cloud(std::size_t i) const override {
    if (i == 2) throw Error(ErrorCode::fileUnreadable, "broken");
    PointCloud cloud;
    cloud.points = {{0, 0, 0}, {0, 1, 1}, {0, 0, 1}};
    cloud.colors.assign(3, {0, 0, 255});
    cloud.width = 3;
    cloud.height = 1;
    return cloud;
  }
  ObjectImage image(std::size_t i) const override {
    if (i > 0) return {};
    cv::Mat mask = cv::Mat::zeros(20, 20, CV_8U);
    mask({5, 5, 7, 3}).setTo(255);
    return {cv::Mat(20, 20, CV_8UC3, cv::Scalar(1, 2, 3)), {5, 5, 7, 3}, mask};
  }

 private:
  std::vector<ObjectView> views_ = {
      {"a/1", "a", "mug", "", ""}, {"b/1", "b", "", "", ""}, {"b/2", "b", "bowl", "", ""}};
};

TEST(Patches, AFrameAView) {
  const Three views;
  const auto patches = cropsOf(views);
  ASSERT_EQ(patches->size(), 3U);
  EXPECT_EQ(patches->name(), "three");
  EXPECT_EQ(patches->frame(0).name, "a/1");
  EXPECT_EQ(patches->frame(0).room, "mug");
  EXPECT_EQ(patches->frame(1).room, "");
  EXPECT_EQ(patches->fingerprint(0), "") << "labels are remembered by pixels";
  EXPECT_THAT(patches->warnings(), ElementsAre("one is odd"));
  const cv::Mat cut = patches->image(0), drawn = patches->image(1);
  EXPECT_EQ(cut.size(), cv::Size(8, 8));
  EXPECT_EQ(cut.at<cv::Vec3b>(0, 0), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(drawn.size(), cv::Size(299, 299));
  cv::Mat red;
  cv::inRange(drawn, cv::Scalar(0, 0, 255), cv::Scalar(0, 0, 255), red);
  EXPECT_GT(cv::countNonZero(red), 0);
  EXPECT_EQ(test::caught([&] { patches->image(2); }).message, "broken");
}

TEST(Patches, OptionsAreThoseOfThePatch) {
  const Three views;
  CropOptions options;
  options.background = CropOptions::Background::gray;
  EXPECT_EQ(cropsOf(views, options)->image(0).at<cv::Vec3b>(0, 0), cv::Vec3b(128, 128, 128));
  options.margin = 9;
  EXPECT_TRUE(test::caught([&] { cropsOf(views, options)->image(1); }).code.has_value());
}

}  // namespace
}  // namespace estancia
