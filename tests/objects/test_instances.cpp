// Instances of things: found from frames, and judged by those that are there.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/instance_map.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
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
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using Stands = ObjectInstance::Stands;

const CameraIntrinsics kCamera{160, 120, 131, 131, 79.5, 59.5};
const Floor kFloor{cv::Vec3d(0, 0, 1)};

/// What a camera sees of boxes on a floor: depth, and the number of each pixel's box, 0 for the floor.
struct BoxView {
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

BoxView viewOf(const std::vector<OrientedBox>& boxes, const Pose& pose, double noise = 0) {
  BoxView view;
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

/// What is found of boxes that are seen from all sides, where each view is changed.
std::vector<ObjectInstance> foundOf(
    const std::vector<OrientedBox>& boxes,
    const std::function<void(std::size_t, BoxView&)>& change = [](std::size_t, BoxView&) {},
    double noise = 0) {
  InstanceMap map(kFloor);
  for (std::size_t i = 0; i < 16; ++i) {
    BoxView view = viewOf(boxes, around(i, 16), noise);
    change(i, view);
    map.add(i, view.depth, view.segments, kCamera, around(i, 16));
  }
  return map.instances();
}

TEST(InstanceMap, TwoEqualChairsAreTwoFromAllSides) {
  const std::vector<ObjectInstance> found = foundOf(
      {chair, other}, [](std::size_t, BoxView&) {}, 0.0012);
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
  const std::vector<ObjectInstance> found = foundOf({table, parcel}, [](std::size_t i, BoxView& view) {
    if (i % 4 == 0) view.segments.setTo(1, view.segments == 2);  // takes both for one
  });
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
    return foundOf({chair}, [&](std::size_t i, BoxView& view) {
      if (7 * i % 16 >= 6) view.segments.setTo(pixel, view.segments == 1);
    });
  };
  EXPECT_THAT(thingsWhereOthersSee(wallPixel), SizeIs(1)) << "6 of 6 + 10 / 2";
  EXPECT_THAT(thingsWhereOthersSee(0), IsEmpty()) << "6 of 16";
}

TEST(InstanceMap, PartsWithinAThingBelongToIt) {
  const OrientedBox top{{2, 0, 0.69}, {0.8, 1.6, 0.04}, 0}, side{{2, 0.7, 0.335}, {0.7, 0.06, 0.67}, 0},
      basket{{2, -0.2, 0.15}, {0.3, 0.3, 0.3}, 0};
  const std::vector<ObjectInstance> found = foundOf({top, side, basket});
  ASSERT_THAT(found, SizeIs(2)) << "what stands under a desk touches none of it";
  const OrientedBox desk{{2, 0, 0.355}, {0.8, 1.6, 0.71}, 0};
  EXPECT_THAT(matchBoxes(std::vector{found[0].box, found[1].box}, std::vector{desk, basket}, 0.6), SizeIs(2));
}

TEST(InstanceMap, LoosePixelsBelongToWhatTheyTouch) {
  const OrientedBox pot{{2, 0, 0.2}, {0.4, 0.4, 0.4}, 0}, leaves{{2, 0, 0.55}, {0.2, 0.2, 0.3}, 0};
  const auto heightWhereLeavesAre = [&](std::uint8_t pixel) {
    const std::vector<ObjectInstance> found = foundOf(
        {pot, leaves}, [&](std::size_t, BoxView& view) { view.segments.setTo(pixel, view.segments == 2); });
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
    const BoxView view = viewOf({chair, other}, around(i, 16));
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
  const BoxView view = viewOf({chair, other}, cameraAt(0, 0, 0));
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

OrientedBox cubeAt(double x) {
  return {{x, 0, 0.5}, {1, 1, 1}, 0};
}

TEST(MatchBoxes, TakesTheBestPairsFirstAndEachBoxOnce) {
  const std::vector<OrientedBox> things{cubeAt(0), cubeAt(3), cubeAt(9)},
      found{cubeAt(0.3), cubeAt(0.1), cubeAt(3.2)};
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

/// A sofa and a bed, a mug that was hardly seen, and a stove, which is a fixture.
std::vector<TrueThing> fourThings() {
  return {{10, cubeAt(0), "furniture", true, {"studio couch, day bed"}},
          {11, cubeAt(3), "furniture", true, {"four-poster", "studio couch, day bed"}},
          {12, cubeAt(6), "small", false, {"cup"}},
          {13, cubeAt(9), "fixture", true, {}}};
}

TEST(InstanceAccuracy, CountsWhatIsFoundAndWhatIsThere) {
  const std::vector<FoundInstance> found{{cubeAt(0.1), false, "studio couch, day bed"},
                                         {cubeAt(6), false, "teapot"},
                                         {cubeAt(9), false, ""},
                                         {cubeAt(20), false, "cup"},
                                         {cubeAt(30), true, "cup"}};
  const InstanceAccuracy accuracy = judgeInstances(found, fourThings());
  const InstanceScore& all = accuracy.counted;
  EXPECT_EQ(all.things, 2U) << "neither the fixture nor what was hardly seen";
  EXPECT_EQ(all.found, 1U);
  EXPECT_EQ(all.recall(), 0.5);
  EXPECT_EQ(all.instances, 3U) << "neither the fixture nor what hangs at a wall and is no thing";
  EXPECT_EQ(all.right, 2U) << "a thing that was hardly seen may be found";
  EXPECT_NEAR(*all.precision(), 2. / 3, 1e-12);
  EXPECT_NEAR(*all.error, 0.1, 1e-12);
  EXPECT_EQ(all.nameable, 1U);
  EXPECT_EQ(all.nameAccuracy(), 1.0);
  EXPECT_EQ(accuracy.ofClass.at("fixture").found, 1U);
  EXPECT_EQ(accuracy.ofClass.at("fixture").nameable, 0U);
  EXPECT_EQ(accuracy.ofClass.at("none").instances, 2U);
  EXPECT_EQ(accuracy.ofClass.at("small").right, 1U);
  EXPECT_FALSE(accuracy.split || accuracy.merged) << "nobody knows what the segments show";
  const InstanceScore none = judgeInstances({}, {}).counted;
  EXPECT_FALSE(none.recall() || none.precision() || none.nameAccuracy());
  const std::vector<FoundInstance> wrong{{cubeAt(0), false, "teapot"}, {cubeAt(3), false, ""}};
  EXPECT_EQ(judgeInstances(wrong, fourThings()).counted.nameAccuracy(), 0.0);
}

TEST(InstanceAccuracy, KnowsSplitThingsAndMergedOnesByTheirPixels) {
  const std::vector<FoundInstance> found{{cubeAt(0), false, "", {{10, 70}, {2, 30}}},
                                         {cubeAt(1), false, "", {{10, 90}, {11, 10}}},
                                         {cubeAt(3), false, "", {{11, 70}, {12, 30}}},
                                         {cubeAt(9), false, "", {{1, 80}, {13, 20}}}};
  const InstanceAccuracy accuracy = judgeInstances(found, fourThings());
  EXPECT_EQ(accuracy.split, 1U) << "10, in two instances; walls are no thing";
  EXPECT_EQ(accuracy.merged, 1U) << "11 and 12";
}

TEST(InstanceAccuracy, ThingsCountThatTheImagesOfTheMapShowOftenEnough) {
  io::HomeTruth truth;
  truth.instances.resize(2);
  truth.instances[0].id = 10, truth.instances[0].category = "mug";
  truth.instances[1].id = 11, truth.instances[1].category = "bed";
  for (const char* image : {"a", "b", "c", "d", "e"}) truth.visible[image] = {{10, 150, 150}, {11, 149, 149}};
  const Vocabulary vocabulary({"cup", "stove"});
  const ThingClasses classes{.classOf = {{"bed", "furniture"}},
                             .words = {{"mug", {"cup"}}, {"bed", {"bed"}}}};
  const auto things = trueThings(truth, classes, &vocabulary);
  EXPECT_TRUE(things[0].counts);
  EXPECT_FALSE(things[1].counts);
  EXPECT_EQ(things[0].thingClass, "thing");
  EXPECT_EQ(things[1].thingClass, "furniture");
  EXPECT_THAT(things[0].labels, ElementsAre("cup"));
  EXPECT_TRUE(things[1].labels.empty()) << "the vocabulary has no bed";
  EXPECT_FALSE(trueThings(truth, classes, &vocabulary, {"a", "b", "c", "d"})[0].counts);
  EXPECT_TRUE(trueThings(truth, classes, &vocabulary, {}, 100)[1].counts);
  truth.visible.clear();
  EXPECT_TRUE(trueThings(truth, classes, &vocabulary)[1].counts) << "nobody knows what images show";
}

TEST(ThingClasses, AreReadFromAFile) {
  const test::ScratchFolder folder;
  const auto file = folder / "things.toml";
  const auto read = [&](const std::string& text) {
    test::writeFile(file, text);
    return readThingClasses(file);
  };
  const ThingClasses classes = read(
      "other = \"small\"\n[classes]\nfixture = [\"stove\"]\n[words]\n"
      "mug = [\"coffee mug\", \"cup\"]\n");
  EXPECT_EQ(classes.of("stove"), ThingClasses::fixture);
  EXPECT_EQ(classes.of("mug"), "small");
  EXPECT_THAT(classes.words.at("mug"), ElementsAre("coffee mug", "cup"));
  EXPECT_EQ(read("").of("mug"), "thing");
  for (const char* wrong :
       {"[classes]\na = [\"x\"]\nb = [\"x\"]\n", "[words]\nmug = []\n", "[words]\nmug = 1\n", "typo = 1\n"})
    EXPECT_THAT([&] { read(wrong); }, FailsWith(ErrorCode::malformedFile)) << wrong;
}

}  // namespace
}  // namespace estancia
