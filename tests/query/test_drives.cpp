// Several drives in one map: where they begin, what is recognized, and where their poses are.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/drives.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "estancia/core/pose.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/session/drive_alignment.hpp"
#include "estancia/session/session.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

const cv::Affine3d elsewhere = rigidOf(Pose::planar(7, -3, 2.1));

/// A robot that drives in circles through twelve places, which look differently each time.
class Rounds {
 public:
  static constexpr std::size_t places = 12, stepsOfPlace = 4;

  explicit Rounds(std::size_t others = 0) : look_(places + others, 60, 0.6) {}

  Pose poseAt(std::size_t step) const {
    const double angle = 2 * std::numbers::pi * static_cast<double>(step) / (places * stepsOfPlace);
    return Pose::planar(4 * std::cos(angle), 4 * std::sin(angle), angle + std::numbers::pi / 2);
  }
  std::vector<float> imageAt(std::size_t step) { return look_.image(step / stepsOfPlace % places); }
  std::vector<float> imageOf(std::size_t place) { return look_.image(place); }

 private:
  test::SyntheticPlaces look_;
};

Vocabulary words() {
  std::vector<std::string> names;
  for (int i = 0; i < 60; ++i) names.push_back("word " + std::to_string(i));
  return Vocabulary(names);
}

class Drives : public testing::Test {
 protected:
  MappingSession firstDrive(std::size_t steps = 120) {
    MappingSession map = MappingSession::create(path_, words(), "test", {});
    map.beginDrive({"first"});
    for (std::size_t i = 0; i < steps; ++i) add(map, rounds_.imageAt(i), rounds_.poseAt(i));
    map.finish();
    return map;
  }
  static void add(MappingSession& map, const std::vector<float>& image, const std::optional<Pose>& pose) {
    Frame frame;
    frame.name = "frame " + std::to_string(map.frames());
    frame.pose = pose;
    frame.timestamp = 0.5 * static_cast<double>(map.frames());
    map.add(frame, image);
  }
  /// The pose in the robot's own odometry.
  Pose ownPoseAt(std::size_t step) const { return poseOf(elsewhere.inv() * rigidOf(rounds_.poseAt(step))); }

  test::ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "home.estancia";
  Rounds rounds_{12};
};

TEST_F(Drives, BeginLostAndAreAlignedByRecognizedPlaces) {
  MappingSession map = firstDrive();
  map.beginDrive({"second", "print"});
  EXPECT_EQ(map.mapper().currentNode(), -1);
  for (std::size_t i = 20; i < 80; ++i) add(map, rounds_.imageAt(i), ownPoseAt(i));
  map.finish();
  const TopologicalMap found = readMap(path_);
  ASSERT_EQ(found.drives.size(), 2U);
  EXPECT_EQ(found.drives[1].firstFrame, 120U);
  EXPECT_EQ(found.drives[1].fingerprint, "print");
  ASSERT_TRUE(found.drives[1].alignment);
  for (std::size_t i = 120; i < 180; ++i) {
    ASSERT_TRUE(found.frames[i].pose) << i;
    EXPECT_LT(distanceBetween(*found.frames[i].pose, rounds_.poseAt(i - 100)), 0.5) << i;
  }
  const std::vector<DriveSummary> drives = summarizeDrives(found);
  EXPECT_FALSE(drives[0].recognized);
  ASSERT_TRUE(drives[1].recognized);
  EXPECT_LT(drives[1].recognized->after, 10U);
  EXPECT_EQ(drives[1].posed, 60U);
  EXPECT_EQ(drives[1].begins, 60);
  EXPECT_EQ(drives[1].ends, 89.5);
  // No wrong join: of the frames that are in a place of the first drive, all stood near one of its frames.
  for (std::size_t i = 120; i < 180; ++i) {
    double nearest = 100;
    bool isKnown = false;
    for (std::size_t k = 0; k < 120; ++k)
      if (found.frames[k].node == found.frames[i].node) {
        isKnown = true;
        nearest = std::min(nearest, distanceBetween(*found.frames[k].pose, rounds_.poseAt(i - 100)));
      }
    EXPECT_LT(isKnown ? nearest : 0, 1) << i;
  }
}

TEST_F(Drives, ElsewhereStayApart) {
  MappingSession map = firstDrive();
  map.beginDrive({"another house"});
  for (std::size_t i = 0; i < 48; ++i) add(map, rounds_.imageOf(12 + i / 4), ownPoseAt(i));
  map.finish();
  const TopologicalMap found = readMap(path_);
  EXPECT_FALSE(found.drives[1].isAligned);
  for (std::size_t i = 120; i < 168; ++i) {
    EXPECT_FALSE(found.frames[i].pose);
    for (std::size_t k = 0; k < 120; ++k) EXPECT_NE(found.frames[i].node, found.frames[k].node);
  }
  EXPECT_FALSE(summarizeDrives(found)[1].recognized);
  for (const Transition& transition : found.transitions)
    EXPECT_EQ(transition.from >= found.frames[120].node, transition.to >= found.frames[120].node);
}

TEST_F(Drives, KeepPosesThatAreInTheMap) {
  MappingSession map = firstDrive();
  map.beginDrive({.name = "localized", .posesAreInMap = true});
  for (std::size_t i = 0; i < 5; ++i) add(map, rounds_.imageOf(20), Pose::planar(50, 50, 0));
  map.finish();
  const TopologicalMap found = readMap(path_);
  EXPECT_TRUE(found.drives[1].isAligned);
  EXPECT_FALSE(found.drives[1].alignment);
  EXPECT_EQ(found.frames.back().pose.value().x, 50);
}

TEST_F(Drives, GoOnAfterACrashAsIfNothingHadHappened) {
  const auto driveOn = [&](std::size_t crash) {
    const test::ScratchFolder folder;
    const std::filesystem::path file = folder / "home.estancia";
    Rounds rounds(12);
    std::optional<MappingSession> map(MappingSession::create(file, words(), "test", {}));
    std::vector<int> nodes;
    for (std::size_t i = 0; i < 180; ++i) {
      if (i == 120) map->beginDrive({"second"});
      if (i == crash) {
        map->finish();
        map.reset();
        map.emplace(MappingSession::resume(file, words(), "test"));
      }
      const std::size_t step = i < 120 ? i : i - 100;
      add(*map, rounds.imageAt(step),
          i < 120 ? rounds.poseAt(step) : poseOf(elsewhere.inv() * rigidOf(rounds.poseAt(step))));
    }
    map->finish();
    const TopologicalMap found = readMap(file);
    for (const MappedFrame& frame : found.frames) nodes.push_back(frame.node);
    return std::pair(nodes, found.drives[1].alignment.value());
  };
  const auto [nodes, alignment] = driveOn(1000);
  for (const std::size_t crash : {121U, 137U}) {
    const auto [resumed, aligned] = driveOn(crash);
    EXPECT_EQ(resumed, nodes) << crash;
    EXPECT_EQ(aligned.x, alignment.x) << crash;
  }
}

TEST(MapperDrives, BelieveAGuessUnlessWordsContradict) {
  Rounds rounds(2);
  Mapper mapper(words());
  for (std::size_t i = 0; i < 96; ++i) mapper.add(rounds.imageAt(i));
  const int last = mapper.currentNode();
  mapper.beginDrive();
  mapper.takeChanges();
  const int unknown = mapper.add(rounds.imageOf(Rounds::places), {}, last);
  EXPECT_NE(unknown, last) << "it looks like nothing there";
  mapper.beginDrive();
  mapper.takeChanges();
  EXPECT_EQ(mapper.add(rounds.imageAt(95), {}, last), last);
  const auto events = mapper.takeChanges().events;
  EXPECT_EQ(std::get<Decision>(events.front()).kind, DecisionKind::localize);
}

TEST(MapperDrives, DoNotStayInAPlaceThatIsElsewhereByPoses) {
  Rounds rounds(2);
  const std::vector<float> image = rounds.imageAt(0);
  for (const double step : {0.1, 3.0}) {
    Mapper mapper(words());
    for (int i = 0; i < 20; ++i) mapper.add(image, Pose::planar(step * i, 0, 0));
    EXPECT_EQ(mapper.nodes(), step < 1 ? 1U : 20U) << "look-alikes, " << step << " m apart";
  }
}

TEST(DriveAlignment, IsWhatMostViewsAgreeWith) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.15);
  std::uniform_real_distribution<double> anywhere(-8, 8);
  DriveAlignment alignment(0.7, 30);
  for (int i = 0; i < 60; ++i) {
    const Pose own = Pose::planar(0.3 * i, std::sin(0.2 * i) * 3, 0.1 * i);
    Pose seen = poseOf(elsewhere * rigidOf(own));
    seen.x += noise(random);
    seen.y += noise(random);
    if (i % 3 == 0) seen = Pose::planar(anywhere(random), anywhere(random), anywhere(random));
    alignment.add(own, seen);
    alignment.add(own, seen);  // it has not moved
  }
  EXPECT_EQ(alignment.pairs(), 60U);
  const auto found = alignment.estimate();
  ASSERT_TRUE(found);
  const cv::Affine3d error = found->transform * elsewhere.inv();
  EXPECT_LT(cv::norm(error.translation()), 0.15);
  EXPECT_LT(angleOf(error), 0.03);
  EXPECT_GE(found->agreeing, 39U);

  DriveAlignment nowhere(0.7, 30);
  for (int i = 0; i < 60; ++i) {
    nowhere.add(Pose::planar(0.3 * i, 0, 0.1 * i),
                Pose::planar(anywhere(random), anywhere(random), anywhere(random)));
    EXPECT_FALSE(nowhere.estimate()) << i;
  }
}

}  // namespace
}  // namespace estancia
