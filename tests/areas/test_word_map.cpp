// Word maps: where a thing is that several images show from different sides.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/word_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "support/errors.hpp"
#include "support/floor_scene.hpp"

namespace estancia {
namespace {

using test::boxDepth;
using test::FailsWith;
using test::lookingAt;
using test::smallCamera;

const cv::Rect2d room(0, 0, 5, 4);
constexpr std::array<std::size_t, 1> mug{1};

/// Whether the camera looks at the corner (5, 4), within its field of view.
bool seesCorner(double x, double y, double heading) {
  return std::abs(wrapped(std::atan2(4 - y, 5 - x) - heading)) < 0.5;
}

WordMap mapOfRoom(bool withDepth, std::size_t labels = 4) {
  std::vector<Pose> poses;
  std::vector<bool> seen;
  for (const auto& [x, y] :
       {std::pair(1.0, 1.0), std::pair(4.0, 1.0), std::pair(1.5, 3.0), std::pair(3.5, 2.5)})
    for (int i = 0; i < 12; ++i) {
      const double heading = i * std::numbers::pi / 6;
      poses.push_back(lookingAt(x, y, 1, heading, -0.1));
      seen.push_back(seesCorner(x, y, heading));
    }
  WordMap map(Floor(poses), labels);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    LexicalDescriptor words(labels, 0.0F);
    words[0] = seen[i] ? 0.2F : 0.9F;
    words[1] = seen[i] ? 0.7F : 0.01F;
    if (withDepth)
      map.add(words, boxDepth(poses[i], room), smallCamera(), poses[i]);
    else
      map.add(words, 1.1, poses[i]);
  }
  return map;
}

cv::Point2d strongest(const FloorHeat& heat) {
  cv::Point best;
  cv::minMaxLoc(heat.values, nullptr, nullptr, nullptr, &best);
  return heat.cells.centerOf(best);
}

TEST(WordMap, KeepsTheMostProbableOfManyLabels) {
  const Pose pose = lookingAt(2, 2, 1, 0, -0.1);
  WordMap map(Floor(std::vector{pose}), 400);
  LexicalDescriptor words(400);
  for (std::size_t l = 0; l < words.size(); ++l) words[l] = static_cast<float>(l + 1) / 400;
  for (int i = 0; i < 3; ++i) map.add(words, 1.1, pose);
  const auto heatOf = [&](std::size_t label) {
    double most = 0;
    cv::minMaxLoc(map.heat(std::array<std::size_t, 1>{label}).values, nullptr, &most);
    return most;
  };
  EXPECT_GT(heatOf(399), 0);
  EXPECT_GT(heatOf(399), heatOf(0));
}

TEST(WordMap, FindsAThingWhereTheViewsCross) {
  const cv::Point2d at = strongest(mapOfRoom(true).heat(mug));
  EXPECT_LT(std::hypot(at.x - 5, at.y - 4), 0.75);
}

TEST(WordMap, WithoutDepthKnowsTheSide) {
  const WordMap map = mapOfRoom(false);
  const FloorHeat heat = map.heat(mug);
  const auto valueAt = [&](double x, double y) { return heat.values.at<float>(heat.cells.at(x, y)); };
  EXPECT_GT(valueAt(4.5, 3.5), 3 * valueAt(0.5, 0.5));
}

TEST(WordMap, MeansOfCellsArePooledByWhatWasSeen) {
  const WordMap map = mapOfRoom(true);
  const cv::Mat all(map.cells().rows(), map.cells().columns(), CV_8U, cv::Scalar(255));
  const std::vector<float> mean = map.mean(all);
  EXPECT_GT(mean[0], mean[1]);
  EXPECT_GT(mean[1], 0.02F);
  EXPECT_EQ(mean[2], 0);  // never more probable than by chance
  EXPECT_THAT(map.mean(all * 0), testing::Each(0.0F));
}

TEST(WordMap, RefusesWhatDoesNotFit) {
  const Pose pose = lookingAt(1, 1, 1, 0, 0);
  WordMap map(Floor(std::vector{pose}), 4);
  EXPECT_THAT([&] { map.add(LexicalDescriptor(3, 0.1F), 1.0, pose); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { map.heat(std::array<std::size_t, 1>{4}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_TRUE(map.heat(mug).values.empty());
}

}  // namespace
}  // namespace estancia
