// Segments of a made-up room become things: one each, whatever the side and however often seen.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/instance_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <utility>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/objects/instance_accuracy.hpp"
#include "estancia/objects/object_instance.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::IsEmpty;
using testing::SizeIs;
using Stands = ObjectInstance::Stands;

const CameraIntrinsics kCamera{160, 120, 131, 131, 79.5, 59.5};
const Floor kFloor{cv::Vec3d(0, 0, 1)};

/// What a camera sees of boxes on a floor: depth, and the number of each pixel's box, 0 for the floor.
struct View {
  cv::Mat depth{kCamera.height, kCamera.width, CV_32F, cv::Scalar(0)};
  cv::Mat segments{kCamera.height, kCamera.width, CV_8U, cv::Scalar(0)};
};

/// Distance along a ray from `from` to a box that is not turned; infinite where it misses.
double distanceTo(const OrientedBox& box, const cv::Vec3d& from, const cv::Vec3d& ray) {
  const double center[] = {box.center.x, box.center.y, box.center.z};
  const double half[] = {box.size.x / 2, box.size.y / 2, box.size.z / 2};
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    double a = (center[axis] - half[axis] - from[axis]) / ray[axis];
    double b = (center[axis] + half[axis] - from[axis]) / ray[axis];
    if (a > b) std::swap(a, b);
    enter = std::max(enter, a);
    leave = std::min(leave, b);
  }
  return enter <= leave && leave > 0 ? enter : std::numeric_limits<double>::infinity();
}

View viewOf(const std::vector<OrientedBox>& boxes, const Pose& pose, double noise = 0) {
  View view;
  const cv::Affine3d rigid = rigidOf(pose);
  std::mt19937 random(1);
  std::normal_distribution<double> error;
  for (int v = 0; v < view.depth.rows; ++v)
    for (int u = 0; u < view.depth.cols; ++u) {
      const cv::Vec3d ray = rigid.rotation() * cv::Vec3d(kCamera.slopeX(u) + 1e-9, kCamera.slopeY(v), 1);
      double nearest = ray[2] < 0 ? -pose.z / ray[2] : 0;
      if (nearest > 8) nearest = 0;
      for (std::size_t b = 0; b < boxes.size(); ++b)
        if (const double d = distanceTo(boxes[b], rigid.translation(), ray);
            d < 8 && (nearest == 0 || d < nearest)) {
          nearest = d;
          view.segments.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(b + 1);
        }
      view.depth.at<float>(v, u) = static_cast<float>(nearest + noise * nearest * nearest * error(random));
    }
  return view;
}

/// 1.2 m high at (x, y), looking along `heading` and a little down.
Pose cameraAt(double x, double y, double heading) {
  const cv::Affine3d level = rigidOf(Pose::planar(x, y, heading));
  Pose pose = poseOf(level * cv::Affine3d(cv::Vec3d(-0.3, 0, 0), cv::Vec3d()));
  pose.z = 1.2;
  return pose;
}

/// On a circle around (2, 0).
Pose around(std::size_t i, std::size_t of) {
  const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(of);
  return cameraAt(2 + 2.5 * std::cos(angle), 2.5 * std::sin(angle), angle + std::numbers::pi);
}

const OrientedBox chair{{2, 0.6, 0.4}, {0.5, 0.5, 0.8}, 0}, other{{2, -0.6, 0.4}, {0.5, 0.5, 0.8}, 0};

TEST(InstanceMap, TwoEqualChairsAreTwoFromAllSides) {
  InstanceMap map(kFloor);
  for (std::size_t i = 0; i < 16; ++i) {
    const View view = viewOf({chair, other}, around(i, 16), 0.0012);
    map.add(i, view.depth, view.segments, kCamera, around(i, 16));
  }
  const std::vector<ObjectInstance> found = map.instances();
  ASSERT_THAT(found, SizeIs(2));
  const std::vector<OrientedBox> boxes{found[0].box, found[1].box};
  EXPECT_THAT(matchBoxes(boxes, std::vector{chair, other}, 0.6), SizeIs(2));
  for (const ObjectInstance& instance : found) {
    EXPECT_GE(instance.views, 14U);  // one may hide the other
    EXPECT_EQ(instance.stands, Stands::floor);
  }
}

TEST(InstanceMap, MostFramesDecideWhatIsOneThing) {
  const OrientedBox table{{2, 0, 0.35}, {0.8, 1.2, 0.7}, 0}, parcel{{2, 0, 0.85}, {0.3, 0.3, 0.3}, 0};
  InstanceMap map(kFloor);
  for (std::size_t i = 0; i < 16; ++i) {
    View view = viewOf({table, parcel}, around(i, 16));
    if (i % 4 == 0) view.segments.setTo(1, view.segments == 2);  // takes both for one
    map.add(i, view.depth, view.segments, kCamera, around(i, 16));
  }
  const std::vector<ObjectInstance> found = map.instances();
  ASSERT_THAT(found, SizeIs(2));
  const bool first = found[0].box.center.z > found[1].box.center.z;
  const ObjectInstance &on = found[first ? 0 : 1], &below = found[first ? 1 : 0];
  EXPECT_EQ(on.stands, Stands::instance);
  EXPECT_EQ(&found[static_cast<std::size_t>(on.on)], &below);
  EXPECT_EQ(below.stands, Stands::floor);
  EXPECT_GT(intersectionOverUnion(on.box, parcel), 0.5);
}

TEST(InstanceMap, AWallHasHalfAVote) {
  const auto thingsWhereOthersSee = [](std::uint8_t pixel) {
    InstanceMap map(kFloor);
    for (std::size_t i = 0; i < 16; ++i) {
      View view = viewOf({chair}, around(i, 16));
      if (7 * i % 16 >= 6) view.segments.setTo(pixel, view.segments == 1);
      map.add(i, view.depth, view.segments, kCamera, around(i, 16));
    }
    return map.instances();
  };
  EXPECT_THAT(thingsWhereOthersSee(wallPixel), SizeIs(1)) << "6 of 6 + 10 / 2";
  EXPECT_THAT(thingsWhereOthersSee(0), IsEmpty()) << "6 of 16";
}

TEST(InstanceMap, PartsWithinAThingBelongToIt) {
  const OrientedBox top{{2, 0, 0.69}, {0.8, 1.6, 0.04}, 0}, side{{2, 0.7, 0.335}, {0.7, 0.06, 0.67}, 0},
      basket{{2, -0.2, 0.15}, {0.3, 0.3, 0.3}, 0};
  InstanceMap map(kFloor);
  for (std::size_t i = 0; i < 16; ++i) {
    const View view = viewOf({top, side, basket}, around(i, 16));
    map.add(i, view.depth, view.segments, kCamera, around(i, 16));
  }
  const std::vector<ObjectInstance> found = map.instances();
  ASSERT_THAT(found, SizeIs(2)) << "what stands under a desk touches none of it";
  const OrientedBox desk{{2, 0, 0.355}, {0.8, 1.6, 0.71}, 0};
  EXPECT_THAT(matchBoxes(std::vector{found[0].box, found[1].box}, std::vector{desk, basket}, 0.6), SizeIs(2));
}

TEST(InstanceMap, LoosePixelsBelongToWhatTheyTouch) {
  const OrientedBox pot{{2, 0, 0.2}, {0.4, 0.4, 0.4}, 0}, leaves{{2, 0, 0.55}, {0.2, 0.2, 0.3}, 0};
  const auto heightWhereLeavesAre = [&](std::uint8_t pixel) {
    InstanceMap map(kFloor);
    for (std::size_t i = 0; i < 16; ++i) {
      View view = viewOf({pot, leaves}, around(i, 16));
      view.segments.setTo(pixel, view.segments == 2);
      map.add(i, view.depth, view.segments, kCamera, around(i, 16));
    }
    const std::vector<ObjectInstance> found = map.instances();
    return found.size() == 1 ? found[0].box.size.z : 0;
  };
  EXPECT_NEAR(heightWhereLeavesAre(loosePixel), 0.7, 0.05);
  EXPECT_NEAR(heightWhereLeavesAre(0), 0.4, 0.05);
}

TEST(InstanceMap, DoesNotDependOnTheAxesOfTheMap) {
  const cv::Affine3d turned(cv::Vec3d(0.3, -1.1, 0.4), cv::Vec3d(5, -7, 2));
  const Floor floor(turned.rotation() * cv::Vec3d(0, 0, 1));
  InstanceMap map(floor);
  for (std::size_t i = 0; i < 16; ++i) {
    const View view = viewOf({chair, other}, around(i, 16));
    map.add(i, view.depth, view.segments, kCamera, poseOf(turned * rigidOf(around(i, 16))));
  }
  const std::vector<ObjectInstance> found = map.instances();
  ASSERT_THAT(found, SizeIs(2));
  for (const ObjectInstance& instance : found) {
    const cv::Point3d at = turned.inv() * floor.point(instance.box.center);
    EXPECT_NEAR(at.x, 2, 0.05);
    EXPECT_NEAR(std::abs(at.y), 0.6, 0.05);
    EXPECT_NEAR(instance.box.size.z, 0.8, 0.06);
  }
}

TEST(InstanceMap, AsksForImagesOfWhatHasNone) {
  InstanceMap map(kFloor);
  const View view = viewOf({chair, other}, cameraAt(0, 0, 0));
  map.add(0, view.depth, view.segments, kCamera, cameraAt(0, 0, 0));
  const std::vector<double> before = map.worthLabeling();
  ASSERT_THAT(before, SizeIs(2));
  EXPECT_NEAR(before[0], before[1], 0.1 * before[1]);
  map.labeled({0, 1});
  map.add(1, view.depth, view.segments, kCamera, cameraAt(0, 0, 0));
  const std::vector<double> after = map.worthLabeling();
  EXPECT_LT(after[0], after[1] / 2);
  EXPECT_THAT([&] { map.labeled({0, 3}); }, FailsWith(ErrorCode::invalidInput));
}

TEST(InstanceMap, RefusesOrSurvivesBadInput) {
  InstanceMap map(kFloor);
  const Pose pose = cameraAt(0, 0, 0);
  EXPECT_THAT(map.instances(), IsEmpty());
  EXPECT_THAT([&] { map.add(0, cv::Mat(4, 4, CV_16U), cv::Mat(4, 4, CV_8U), kCamera, pose); },
              FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { map.add(0, cv::Mat(4, 4, CV_32F), cv::Mat(4, 5, CV_8U), kCamera, pose); },
              FailsWith(ErrorCode::invalidInput));
  const cv::Mat none(kCamera.height, kCamera.width, CV_32F, cv::Scalar(0)), nan = none + std::nanf("");
  const cv::Mat all(kCamera.height, kCamera.width, CV_8U, cv::Scalar(1)), wall = none + 1e9F;
  for (std::size_t i = 0; i < 5; ++i)
    for (const cv::Mat& depth : {none, nan, wall}) map.add(i, depth, all, kCamera, pose);
  EXPECT_THAT(map.instances(), IsEmpty());
  cv::Mat speck = none.clone(), one = cv::Mat::zeros(none.size(), CV_8U);
  speck.at<float>(60, 80) = 2;  // a thing without extent
  one.at<std::uint8_t>(60, 80) = 255;
  for (std::size_t i = 5; i < 15; ++i) map.add(i, speck, one, kCamera, pose);
  EXPECT_THAT(map.instances(), IsEmpty());
  InstanceMapOptions options;
  options.voxel = 0;
  EXPECT_THAT([&] { InstanceMap(kFloor, options); }, FailsWith(ErrorCode::invalidOption));
}

TEST(MatchBoxes, TakesTheBestPairsFirstAndEachBoxOnce) {
  const auto cube = [](double x) { return OrientedBox{{x, 0, 0.5}, {1, 1, 1}, 0}; };
  const std::vector<OrientedBox> things{cube(0), cube(3), cube(9)}, found{cube(0.3), cube(0.1), cube(3.2)};
  const auto matches = matchBoxes(found, things);
  ASSERT_THAT(matches, SizeIs(2));
  EXPECT_EQ(matches[0].found, 1U);
  EXPECT_EQ(matches[0].thing, 0U);
  EXPECT_EQ(matches[1].found, 2U);
  EXPECT_EQ(matches[1].thing, 1U);
  EXPECT_NEAR(matches[1].overlap, 0.8 / 1.2, 1e-5);
  EXPECT_THAT(matchBoxes(found, things, 0.9), IsEmpty());
  EXPECT_THAT(matchBoxes({}, things), IsEmpty());
}

}  // namespace
}  // namespace estancia
