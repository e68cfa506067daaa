// A map beside the truth about its drive, whatever the axes of the map are.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/evaluate_world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "support/errors.hpp"
#include "support/floor_scene.hpp"
#include "support/sample_home.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;

class EvaluateWorld : public testing::Test {
 protected:
  void SetUp() override { test::writeSampleHome(home_); }

  WorldAccuracy judge(const WorldMap& world) {
    std::filesystem::remove(map_);
    test::writeWorld(world, map_);
    return evaluateWorld(map_, home_, std::vector<std::string>(world.places.frames.size(), "west"),
                         readThingClasses(home_ / "things.toml"));
  }

  test::ScratchFolder scratch_;
  const std::filesystem::path map_ = scratch_ / "home.estancia", home_ = scratch_ / "home";
};

TEST_F(EvaluateWorld, JudgesAreasTrajectoryAndObjectsOnAxesOfTheMap) {
  const WorldAccuracy accuracy = judge(test::sampleWorld());
  EXPECT_EQ(accuracy.areas, 4U);
  EXPECT_EQ(accuracy.areasAndRooms->homogeneity, 1);
  EXPECT_LT(accuracy.areasAndRooms->completeness, 1);
  ASSERT_TRUE(accuracy.areasAndRoomsSeen);
  ASSERT_TRUE(accuracy.trajectory);
  EXPECT_EQ(accuracy.trajectory->poses, 8U);
  EXPECT_NEAR(accuracy.trajectory->rmse, 0, 1e-5);
  ASSERT_TRUE(accuracy.objects);
  const InstanceScore& all = accuracy.objects->counted;
  EXPECT_EQ(all.things, 4U);
  EXPECT_EQ(all.found, 3U);
  EXPECT_EQ(all.instances, 6U);
  EXPECT_EQ(all.right, 3U);
  EXPECT_NEAR(*all.error, 0, 1e-4) << "two are where they were, the mug is 1 cm off";
  EXPECT_EQ(all.nameable, 3U) << "the vocabulary has no couch";
  EXPECT_EQ(all.named, 2U) << "the umbrella is to be called a folding chair";
  EXPECT_EQ(accuracy.objects->ofClass.at("furniture").found, 1U);
  EXPECT_FALSE(accuracy.objects->split) << "the map has no observations";
}

TEST_F(EvaluateWorld, ATurnedBoxIsTurnedWithTheMap) {
  WorldMap world = test::sampleWorld();
  world.objects[0].yaw = 0;
  EXPECT_NEAR(*judge(test::sampleWorld()).objects->ofClass.at("furniture").error, 0, 1e-4);
  world.objects[0].size = {3.2, 0.45, 0.75};  // along the other side it has little in common
  EXPECT_EQ(judge(world).objects->ofClass.at("furniture").found, 0U);
}

TEST_F(EvaluateWorld, KnowsSplitThingsByTheSegmentsOfTheObjects) {
  test::writeWorld(test::sampleWorld(), map_);
  {
    MapStore store = MapStore::open(map_, MapStore::Access::write);
    WorldStore layers(store, MapStore::Access::write);
    Observation seen = observe(cv::Mat(6, 8, CV_32F, cv::Scalar(1)), {8, 6, 8, 8, 3.5, 2.5});
    seen.segments = cv::Mat(6, 8, CV_8U, cv::Scalar(1));
    seen.segments.colRange(0, 4) = 2;
    seen.info = {{cv::Rect(0, 0, 8, 6)}, {cv::Rect(0, 0, 8, 6)}};
    layers.putObservation(0, seen);
    layers.putObjects(test::sampleObjects(), {{{0, 1}, 1}, {{0, 2}, 2}});  // both show the mug
    store.commit();
  }
  const auto accuracy = evaluateWorld(map_, home_, std::vector<std::string>(8));
  EXPECT_EQ(accuracy.objects->split, 1U);
  EXPECT_EQ(accuracy.objects->merged, 0U);
}

TEST_F(EvaluateWorld, DoubtsOrRefusesTheTruthOfAnotherDrive) {
  WorldMap world = test::sampleWorld();
  EXPECT_THAT(judge(world).doubts, testing::IsEmpty());
  std::swap(world.places.frames[1].pose, world.places.frames[5].pose);
  EXPECT_THAT(judge(world).doubts, testing::SizeIs(1));
  world = test::sampleWorld();
  world.places.frames.pop_back();
  world.places.decisions.pop_back();
  world.areaOfFrame.pop_back();
  world.zoneOfFrame.pop_back();
  EXPECT_THAT(judge(world).doubts, testing::SizeIs(1));
  world.places.frames[5].name = "other.png";
  EXPECT_THAT([&] { judge(world); }, FailsWith(ErrorCode::mismatch));
}

TEST(TruthFromMap, IsKnownAlsoOfACameraThatStandsOrDrivesStraightOn) {
  const cv::Affine3d turn(cv::Vec3d(0.2, -0.1, 1.3), cv::Vec3d(5, 6, 7));
  for (const double step : {0.0, 0.5}) {
    std::vector<Pose> estimated, truth;
    for (int i = 0; i < 5; ++i) {
      estimated.push_back(test::lookingAt(step * i, 0, 1, 0.3 * i, -0.2));
      truth.push_back(poseOf(turn * rigidOf(estimated.back())));
    }
    const cv::Affine3d found = rigidOf(truthFromMap(estimated, truth));
    EXPECT_LT(angleOf(found.inv() * turn), 1e-9) << step;
    EXPECT_LT(cv::norm(found.translation() - turn.translation()), 1e-9) << step;
  }
}

TEST_F(EvaluateWorld, MeasuresWhatThereIs) {
  WorldMap world = test::sampleWorld();
  world.objects.clear();
  EXPECT_FALSE(judge(world).objects);
  EXPECT_TRUE(judge(world).trajectory);
  world = test::sampleWorld();
  std::filesystem::remove(home_ / "visible.csv");
  std::filesystem::remove(home_ / "instances.csv");
  EXPECT_FALSE(judge(world).objects);
  for (MappedFrame& frame : world.places.frames) frame.pose.reset();
  EXPECT_FALSE(judge(world).trajectory);
}

}  // namespace
}  // namespace estancia
