// A map beside the truth about its drive, and beside another drive.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "estancia/core/pose.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_query/changes.hpp"
#include "estancia/world_query/evaluate_world.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/floor_scene.hpp"
#include "support/sample_home.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::ScratchFolder;

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

/// Around a room of 6 × 6 m with boxes on its floor, looking inward.
class BoxesDrive : public test::FlatDrive {
 public:
  explicit BoxesDrive(test::Boxes boxes, double share = 1) : boxes_(std::move(boxes)) {
    intrinsics_ = CameraIntrinsics{160, 120, 130, 130, 79.5, 59.5};
    frames_.resize(static_cast<std::size_t>(24 * share));
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / 24;
      frames_[i].name = "frame " + std::to_string(i);
      frames_[i].room = "bedroom";
      frames_[i].pose =
          test::lookingAt(2.3 * std::cos(angle), 2.3 * std::sin(angle), 1.3, angle + std::numbers::pi, -0.45);
    }
  }
  cv::Mat image(std::size_t) const override { return {120, 160, CV_8UC3, cv::Scalar(10, 20, 30)}; }
  cv::Mat depth(std::size_t i) const override {
    return test::boxesDepth(*frames_[i].pose, *intrinsics_, boxes_);
  }

 private:
  test::Boxes boxes_;
};

const std::array<cv::Vec3d, 2> table{{{-0.4, -0.3, 0}, {0.4, 0.3, 0.5}}},
    box{{{0.9, 0.7, 0}, {1.2, 1.0, 0.35}}}, bin{{{-1.1, 0.8, 0}, {-0.8, 1.1, 0.4}}};

/// Goes on with the map, or begins it.
void drive(const BoxesDrive& drive, const std::filesystem::path& file) {
  const DescriptorSequence labeled = drive.labeled();
  MappingSession session = std::filesystem::exists(file)
                               ? MappingSession::resume(file, labeled.vocabulary, labeled.model)
                               : MappingSession::create(file, labeled.vocabulary, labeled.model, {});
  WorldMapper world(session);
  session.beginDrive({.name = "boxes", .posesAreInMap = true});
  world.beginDrive();
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Frame frame = drive.frame(i);
    world.observe(frame, labeled.descriptors.row(i), drive.image(i), drive.depth(i), *drive.intrinsics());
    session.add(frame, labeled.descriptors.row(i));
  }
  session.finish();
  world.finish();
}

Changes between(const BoxesDrive& before, const BoxesDrive& now) {
  const ScratchFolder folder;
  drive(before, folder / "room.estancia");
  drive(now, folder / "room.estancia");
  return findChanges(folder / "room.estancia");
}

TEST(Changes, NeedTwoDrivesAndAreNoneWhereNothingChanged) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder / "room.estancia";
  drive(BoxesDrive({table, box}), file);
  EXPECT_THAT([&] { findChanges(file); }, FailsWith(ErrorCode::insufficientData));
  drive(BoxesDrive({table, box}), file);
  const Changes changes = findChanges(file);
  EXPECT_EQ(changes.since, 1U);
  EXPECT_TRUE(changes.objects.empty());
  EXPECT_TRUE(changes.places.empty());
  EXPECT_THAT([&] { findChanges(file, 0); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { findChanges(file, 2); }, FailsWith(ErrorCode::unknownName));
}

TEST(Changes, AreWhatIsGoneAndWhatIsNew) {
  const Changes changes = between(BoxesDrive({table, box}), BoxesDrive({table, bin}));
  ASSERT_EQ(changes.objects.size(), 2U);
  const ObjectChange &gone = changes.objects[0], &now = changes.objects[1];
  EXPECT_EQ(gone.kind, ObjectChange::Kind::gone);
  EXPECT_TRUE(gone.isWhole);
  EXPECT_TRUE(gone.before);
  EXPECT_LT(cv::norm(gone.from - cv::Point3d(1.05, 0.85, 0.2)), 0.15);
  EXPECT_LT(gone.lastBefore, 24U);
  EXPECT_GT(gone.area, 0.1);
  EXPECT_EQ(now.kind, ObjectChange::Kind::appeared);
  EXPECT_LT(cv::norm(now.to - cv::Point3d(-0.95, 0.95, 0.2)), 0.15);
  EXPECT_GE(now.firstNow, 24U);
}

TEST(Changes, AreNotWhatNobodyLookedAtAgain) {
  // The second drive sees the table from one side alone, and neither of the other places.
  BoxesDrive now({table}, 0.1);
  for (std::size_t i = 0; i < now.size(); ++i)
    now.frames_[i].pose =
        test::lookingAt(0, -2.3 + 0.06 * static_cast<double>(i), 1.3, -std::numbers::pi / 2, -0.45);
  EXPECT_TRUE(between(BoxesDrive({table, box}), now).objects.empty());
}

}  // namespace
}  // namespace estancia
