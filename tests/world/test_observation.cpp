// Observations: what of a view is a segment, a wall or loose, and what a map file keeps of it.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/observation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <string>

#include "cloud/made_up_scene.hpp"
#include "estancia/objects/segment_image.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::board;
using test::box;
using test::FailsWith;
using test::level;
using test::see;
using test::Seen;
using test::View;

/// Of the pixels of a shape, the share of which the predicate holds.
template <class Predicate>
double shareOf(const Observation& seen, const Seen& truth, int shape, const Predicate& predicate) {
  double all = 0, right = 0;
  for (int v = 0; v < truth.shape.rows; ++v)
    for (int u = 0; u < truth.shape.cols; ++u) {
      if (truth.shape.at<int>(v, u) != shape) continue;
      ++all;
      right += predicate(seen.segments.at<std::uint8_t>(v, u)) ? 1 : 0;
    }
  return right / all;
}

/// 0 floor, 1 wall, 2 a cupboard before it, 3 a cane that is too thin for a segment.
Seen room(View& view) {
  view.camera = {320, 240, 262.5, 262.5, 159.5, 119.5};
  view.noise = 0;
  view.from = {0.2, -1, 1.3};
  view.to = {-0.2, 1.5, 0.6};
  return see({level(0), board({0, 3, 1.25}, {1, 0, 0}, {0, 0, 1}, 10, 1.25),
              box({-1.2, 2.7, 0}, {0.8, 0.5, 1.1}), box({0.5, 1.5, 0}, {0.02, 0.02, 0.8})},
             view);
}

TEST(Observation, TellsSegmentsWallsAndLoosePixelsApart) {
  View view;
  const Seen truth = room(view);
  Observation seen = observe(truth.depth, view.camera);
  findSegments(seen, {}, {});
  EXPECT_GT(shareOf(seen, truth, 0, [](std::uint8_t p) { return p == 0; }), 0.95);
  // Far away the tolerance of a plane is wide: the lowest part of the wall passes for the floor.
  EXPECT_GT(shareOf(seen, truth, 1, [](std::uint8_t p) { return p == wallPixel; }), 0.8);
  EXPECT_EQ(shareOf(seen, truth, 1, [](std::uint8_t p) { return inSegment(p) || p == loosePixel; }), 0);
  EXPECT_GT(shareOf(seen, truth, 2, [](std::uint8_t p) { return inSegment(p); }), 0.8);
  EXPECT_GT(shareOf(seen, truth, 3, [](std::uint8_t p) { return p == loosePixel; }), 0.8);

  const Observation read = observationFromBytes(toBytes(seen));
  EXPECT_EQ(cv::norm(read.segments, seen.segments, cv::NORM_INF), 0);
  ASSERT_EQ(read.info.size(), seen.info.size());
}

TEST(Observation, OfASegmentThatIsNotThereIsDamaged) {
  View view;
  const Seen truth = room(view);
  Observation seen = observe(truth.depth, view.camera);
  findSegments(seen, {}, {});
  seen.segments.at<std::uint8_t>(0, 0) = static_cast<std::uint8_t>(seen.info.size() + 1);
  EXPECT_THAT([&] { observationFromBytes(toBytes(seen)); },
              FailsWith(ErrorCode::corruptFile, "segments are damaged"));
}

}  // namespace
}  // namespace estancia
