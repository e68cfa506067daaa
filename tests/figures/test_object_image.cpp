// Things drawn into the image that they are in.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "estancia/figures/annotated_image.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using report::drawObjects;

PredictedObject thingAt(const cv::Rect& box, FusedAnswer::Source source, int word) {
  PredictedObject object;
  object.box = box;
  object.answer = {source, word, 0.8, ""};
  return object;
}

int pixelsOf(const cv::Mat& image, const cv::Vec3b& color) {
  int count = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) count += image.at<cv::Vec3b>(y, x) == color ? 1 : 0;
  return count;
}

TEST(ObjectImage, ColorsTellWhatIsBelieved) {
  const cv::Mat image(240, 320, CV_8UC3, cv::Scalar::all(7));
  const cv::Vec3b green(115, 158, 0), blue(178, 114, 0), orange(0, 159, 230), gray(128, 128, 128);
  const cv::Mat drawn =
      drawObjects(image,
                  std::vector<PredictedObject>{thingAt({20, 50, 60, 60}, FusedAnswer::Source::both, 0),
                                               thingAt({120, 50, 60, 60}, FusedAnswer::Source::shape, 1),
                                               thingAt({220, 50, 60, 60}, FusedAnswer::Source::image, 0),
                                               thingAt({20, 150, 60, 60}, FusedAnswer::Source::none, -1)},
                  {"mug", "Töpfe"});
  for (const cv::Vec3b& color : {green, blue, orange, gray}) EXPECT_GT(pixelsOf(drawn, color), 200);
  EXPECT_EQ(pixelsOf(image, {7, 7, 7}), 240 * 320) << "what was given stays as it is";
  EXPECT_EQ(drawn.at<cv::Vec3b>(80, 50), cv::Vec3b(7, 7, 7)) << "the thing can be seen in its box";
}

TEST(ObjectImage, BoxesMayTouchTheBorder) {
  const cv::Mat image(50, 40, CV_8UC3, cv::Scalar::all(7));
  EXPECT_EQ(drawObjects(image, std::vector{thingAt({0, 0, 40, 50}, FusedAnswer::Source::both, 0)},
                        {"a word that is wider than the image"})
                .size(),
            image.size());
}

TEST(ObjectImage, RefusesGrayImagesAndWordsWithoutAName) {
  EXPECT_THAT([] { drawObjects(cv::Mat(9, 9, CV_8U), {}, {}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT(([] {
                drawObjects(cv::Mat(9, 9, CV_8UC3),
                            std::vector{thingAt({0, 0, 5, 5}, FusedAnswer::Source::both, 3)}, {"mug"});
              }),
              FailsWith(ErrorCode::mismatch));
}

TEST(FloorPlan, ShowsAreasOrHeat) {
  const WorldMap world = sampleWorld();
  std::vector<Pose> poses;
  Zones zones{world.places.vocabulary};
  for (const MappedFrame& frame : world.places.frames) {
    zones.frames.push_back(frame);
    poses.push_back(*frame.pose);
  }
  const Areas areas{*world.plan, std::move(zones), WordMap(Floor(poses), 6)};
  const cv::Mat plan = report::drawFloorPlan(areas, nullptr, 300);
  EXPECT_NEAR(plan.cols, 300, 60);
  EXPECT_LT(pixelsOf(plan, {255, 255, 255}), static_cast<int>(plan.total()));
  const FloorHeat heat{areas.cells,
                       cv::Mat(areas.cells.rows(), areas.cells.columns(), CV_32F, cv::Scalar(0.5F))};
  EXPECT_GT(cv::norm(report::drawFloorPlan(areas, &heat, 300), plan), 0);
}

}  // namespace
}  // namespace estancia::test
