// Views of one thing stay one thing.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core/affine.hpp>

#include "estancia/core/pose.hpp"
#include "estancia/objects/tracks.hpp"
#include "support/errors.hpp"

namespace estancia::test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const CameraIntrinsics camera{640, 480, 525, 525, 319.5, 239.5};

/// A ball's cluster as a camera at `pose` sees it.
Cluster ball(const cv::Vec3d& inMap, double radius, const Pose& pose = {}) {
  const cv::Vec3d c = rigidOf(pose).inv() * inMap;
  const double u = camera.fx * c[0] / c[2] + camera.cx, v = camera.fy * c[1] / c[2] + camera.cy;
  const double r = camera.fx * radius / c[2];
  Cluster cluster;
  cluster.center = cv::Point3f(cv::Vec3f(c));
  cluster.box = cv::Rect(cvRound(u - r), cvRound(v - r), cvRound(2 * r), cvRound(2 * r));
  return cluster;
}

Clusters of(std::vector<Cluster> clusters) {
  return {{}, std::move(clusters)};
}

TEST(Tracks, KeepTheNumbersWhateverTheOrder) {
  Tracks tracks;
  const Cluster left = ball({-0.3, 0, 1}, 0.05), right = ball({0.3, 0, 1}, 0.05);
  EXPECT_THAT(tracks.follow(of({left, right}), camera, {}), ElementsAre(0, 1));
  EXPECT_THAT(tracks.follow(of({ball({0.31, 0.01, 1}, 0.05), ball({-0.29, 0, 1.01}, 0.05)}), camera, {}),
              ElementsAre(1, 0));
  EXPECT_THAT(tracks.follow(of({}), camera, {}), IsEmpty());
}

TEST(Tracks, NoTwoClustersAreOneThing) {
  Tracks tracks;
  tracks.follow(of({ball({0, 0, 1}, 0.1)}), camera, {});
  const auto things = tracks.follow(of({ball({0.02, 0, 1}, 0.1), ball({0.004, 0, 1}, 0.1)}), camera, {});
  EXPECT_THAT(things, ElementsAre(1, 0)) << "the one that overlaps more keeps the number";
}

TEST(Tracks, TellWhichThingsMayBeFoundAgain) {
  Tracks tracks;
  const Cluster left = ball({-0.3, 0, 1}, 0.05), right = ball({0.3, 0, 1}, 0.05);
  tracks.follow(of({left, right}), camera, {});
  for (int frame = 0; frame < 5; ++frame) tracks.follow(of({right}), camera, {});
  EXPECT_THAT(tracks.tracked(), ElementsAre(0, 1));
  tracks.follow(of({right}), camera, {});
  EXPECT_THAT(tracks.tracked(), ElementsAre(1));
  tracks.follow(of({left, right}), camera, {});
  EXPECT_THAT(tracks.tracked(), ElementsAre(1, 2)) << "it is new to whoever has forgotten it";
}

TEST(Tracks, WhatCoversTheSamePixelsFarBehindIsAnotherThing) {
  Tracks tracks;
  tracks.follow(of({ball({0, 0, 1}, 0.05)}), camera, {});
  EXPECT_THAT(tracks.follow(of({ball({0, 0, 2}, 0.1)}), camera, {}), ElementsAre(1));
}

TEST(Tracks, PosesLetTheCameraMoveFar) {
  const cv::Vec3d mug(0, 0, 1.2), can(0.15, 0, 1.2);
  const Pose start;
  const Pose later = poseOf(cv::Affine3d(cv::Vec3d(0, -0.2, 0), cv::Vec3d(0.5, 0, 0.1)));
  for (const bool posed : {true, false}) {
    Tracks tracks;
    const auto known = [&](const Pose& pose) { return posed ? std::optional(pose) : std::nullopt; };
    EXPECT_THAT(tracks.follow(of({ball(mug, 0.05, start), ball(can, 0.05, start)}), camera, known(start)),
                ElementsAre(0, 1));
    const auto things =
        tracks.follow(of({ball(can, 0.05, later), ball(mug, 0.05, later)}), camera, known(later));
    if (posed)
      EXPECT_THAT(things, ElementsAre(1, 0));
    else
      EXPECT_THAT(things, ElementsAre(2, 3)) << "nothing lies where it was";
  }
}

TEST(Tracks, AFrameWithoutAPoseGoesByThePixels) {
  Tracks tracks;
  const Cluster mug = ball({0, 0, 1}, 0.05);
  EXPECT_THAT(tracks.follow(of({mug}), camera, Pose{}), ElementsAre(0));
  EXPECT_THAT(tracks.follow(of({mug}), camera, {}), ElementsAre(0));
  Pose broken;
  broken.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(tracks.follow(of({mug}), camera, broken), ElementsAre(0));
  EXPECT_THAT(tracks.follow(of({mug}), camera, Pose{}), ElementsAre(0));
}

TEST(Tracks, RefuseWhatTheyCannotWorkWith) {
  EXPECT_THAT([] { Tracks().follow({}, {}, {}); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia::test
