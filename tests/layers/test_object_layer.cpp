// Which segments of a view are labeled.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/layers/object_layer.hpp"

#include <gtest/gtest.h>

#include "support/counting_labeler.hpp"
#include "support/floor_scene.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

/// Nine things side by side.
Observation nineThings() {
  Observation seen;
  seen.depth = cv::Mat(48, 63, CV_16U, cv::Scalar(1500));
  seen.camera = {63, 48, 50, 50, 31, 23.5};
  seen.segments = cv::Mat(48, 63, CV_8U);
  for (int i = 0; i < 9; ++i) {
    const cv::Rect box(7 * i, 0, 7, 48);
    seen.segments(box).setTo(i + 1);
    seen.info.push_back({box});
  }
  return seen;
}

TEST(ObjectLayer, LabelsWhatTheFramesBeforeDidNotButNeverMuchAtOnce) {
  const test::ScratchFolder folder;
  test::CountingLabeler labeler({"bed", "stove"}, {0.8F, 0.2F});
  MapStore map = MapStore::create(folder / "map.estancia", {labeler.vocabulary(), "test", "{}"});
  WorldStore store(map, MapStore::Access::write);
  ObjectLayer layer(store, labeler.vocabulary(), {}, &labeler, 1);
  layer.restart(Floor(cv::Vec3d(0, 0, 1)));
  const Observation seen = nineThings();
  const auto labeledAt = [&](std::size_t frame) {
    labeler.asked = 0;
    layer.add(frame, depthOf(seen), seen, test::lookingAt(0, 0, 1, 0, 0));
    layer.label(frame, seen, cv::Mat(48, 63, CV_8UC3, cv::Scalar(1, 2, 3)));
    return labeler.asked;
  };
  EXPECT_EQ(labeledAt(0), 1U);
  EXPECT_EQ(labeledAt(1), 1U);
  EXPECT_EQ(labeledAt(3), 2U);
  EXPECT_EQ(labeledAt(40), 3U);
  EXPECT_EQ(store.views().size(), 7U);
}

}  // namespace
}  // namespace estancia
