// A map that tracks its camera itself: through loop closures, interruptions, and frames that are wrong.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>
#include <set>

#include "estancia/core/pose.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/odometry/tracker.hpp"
#include "estancia/stats/trajectory_error.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "support/errors.hpp"
#include "support/room.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::Drive;
using test::FailsWith;
using test::ScratchFolder;
using test::turnAround;

/// The path of a camera that looks down by 20° and leans by 8°.
std::vector<Pose> tilted(const std::vector<Pose>& path) {
  const cv::Affine3d tilt = cv::Affine3d(cv::Vec3d(-20 * CV_PI / 180, 0, 0), cv::Vec3d()) *
                            cv::Affine3d(cv::Vec3d(0, 0, 8 * CV_PI / 180), cv::Vec3d());
  std::vector<Pose> poses;
  for (const Pose& pose : path) poses.push_back(poseOf(rigidOf(pose) * tilt));
  return poses;
}

/// How far a motion is from another one [m, or rad where that is more].
double offBy(const Pose& fromA, const Pose& toA, const Pose& fromB, const Pose& toB) {
  const cv::Affine3d off = (rigidOf(fromA).inv() * rigidOf(toA)).inv() * rigidOf(fromB).inv() * rigidOf(toB);
  return std::max(cv::norm(off.translation()), angleOf(off));
}

/// Names everything the same.
class OneWordLabeler : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return "test"; }
  Prepared prepare(const cv::Mat& bgr, const std::string& /*frame*/) const override { return {bgr, "", {}}; }
  LexicalDescriptor infer(const Prepared& image) override {
    LexicalDescriptor words(24, 0.01F);
    words[static_cast<std::size_t>(image.input.cols) % 24] = 0.7F;
    return words;
  }

 private:
  Vocabulary vocabulary_ = [] {
    std::vector<std::string> words;
    for (int i = 0; i < 24; ++i) words.push_back("word " + std::to_string(i));
    return Vocabulary(words);
  }();
};

/// Much drift, some loops, and every correction is reported.
WorldOptions manyCorrections() {
  WorldOptions options;
  options.odometry.keyframeOverlap = 0.9;
  options.odometry.minLoopFeatures = 15;
  options.odometry.minCorrection = 0.002;
  return options;
}

/// Maps the frames of a drive, and looks at none of their poses.
class TrackedMap {
 public:
  TrackedMap(const Drive& drive, const fs::path& file, const WorldOptions& options = manyCorrections(),
             std::optional<CameraIntrinsics> camera = {})
      : drive_(drive),
        words_(wordsByHeading(drive)),
        session_(fs::exists(file) ? MappingSession::resume(file, labeler_.vocabulary(), "test")
                                  : MappingSession::create(file, labeler_.vocabulary(), "test", {})),
        world_(session_, options, &labeler_, camera ? camera : drive.intrinsics()) {}

  void addUpTo(std::size_t end) {
    for (std::size_t i = session_.frames(); i < end; ++i) {
      Frame frame = drive_.frame(i);
      frame.pose.reset();
      cv::Mat depth;
      if (!drive_.noDepthFile.contains(i)) depth = drive_.depth(i);
      const LexicalDescriptor words = words_.describe(i);
      frame.pose = world_.observe(frame, words, drive_.image(i), depth, *drive_.intrinsics());
      session_.add(frame, words);
    }
  }
  void finish() {
    session_.finish();
    world_.finish();
  }
  MappingSession& session() { return session_; }
  WorldMapper& world() { return world_; }

 private:
  const Drive& drive_;
  FrameWords words_;
  OneWordLabeler labeler_;
  MappingSession session_;
  WorldMapper world_;
};

void mapAll(const Drive& drive, const fs::path& file) {
  TrackedMap map(drive, file);
  map.addUpTo(drive.size());
  map.finish();
}

/// All that stands in the file, row by row, but for free pages and the order of rows.
std::string contentOf(const fs::path& file) {
  sqlite::Database database(file, sqlite::Database::Mode::read);
  std::vector<std::string> tables;
  sqlite::Statement names(database, "SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name");
  while (names.next()) tables.push_back(names.text(0));
  std::string content;
  for (const std::string& table : tables) {
    sqlite::Statement columns(database,
                              "SELECT group_concat('quote(' || name || ')', '||'' ''||') FROM "
                              "pragma_table_info('" +
                                  table + "')");
    columns.next();
    content += table + "\n";
    sqlite::Statement rows(database, "SELECT " + columns.text(0) + " AS row FROM " + table + " ORDER BY row");
    while (rows.next()) content += rows.text(0) + "\n";
  }
  return content;
}

std::size_t observationsOf(const fs::path& file) {
  sqlite::Database database(file, sqlite::Database::Mode::read);
  return static_cast<std::size_t>(database.number("SELECT count(*) FROM observations"));
}

TEST(SelfTracking, PlacesTheFramesOfADriveWithoutPoses) {
  const ScratchFolder folder;
  const Drive drive(turnAround(30, 8), 1);
  const fs::path file = folder / "room.estancia";
  TrackedMap map(drive, file);
  const FrameWords words = wordsByHeading(drive);
  RgbdTracker tracker(*drive.intrinsics(), manyCorrections().odometry);
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Frame& frame = drive.frame(i);
    tracker.add(drive.image(i), drive.depth(i),
                {frame.name, frame.timestamp, {}, [&] { return words.describe(i); }});
    if (i % 5 != 4) continue;
    map.addUpTo(i + 1);
    const TopologicalMap places = map.session().map();
    for (std::size_t k = 0; k <= i; ++k)
      EXPECT_LT(offBy(places.frames[0].pose.value(), places.frames[k].pose.value(),
                      tracker.at(0).pose.value(), tracker.at(k).pose.value()),
                1e-9)
          << k << " after " << i;
  }
  EXPECT_GT(tracker.revision(), 0U) << "earlier frames move while it drives";
  map.addUpTo(drive.size());
  map.finish();
  const RgbdTrajectory alone = trackRgbd(drive, manyCorrections().odometry, words);
  ASSERT_TRUE(map.world().odometry());
  const RgbdTrajectory& found = *map.world().odometry();
  EXPECT_EQ(found.keyframes, alone.keyframes);
  EXPECT_FALSE(found.loops.empty());
  EXPECT_GT(found.corrections, 0U);
  EXPECT_LT(errorOf(found, drive), 0.03);
  const WorldMap world = readWorld(file);
  ASSERT_EQ(world.places.frames.size(), drive.size());
  for (std::size_t i = 0; i < drive.size(); ++i) {
    ASSERT_TRUE(world.places.frames[i].pose) << i;
    EXPECT_LT(
        offBy(*world.places.frames[0].pose, *world.places.frames[i].pose, *alone.poses[0], *alone.poses[i]),
        1e-9)
        << i;
  }
  ASSERT_EQ(world.areas.size(), 1U) << "the room";
  EXPECT_NEAR(world.areas[0].size, 20, 5);
  EXPECT_FALSE(world.objects.empty());
}

TEST(SelfTracking, LevelsTheMapOfATiltedCamera) {
  const ScratchFolder folder;
  const Drive drive(tilted(turnAround(30, 8)), 1);
  const fs::path file = folder / "room.estancia";
  TrackedMap map(drive, file);
  map.addUpTo(drive.size());
  map.finish();
  ASSERT_TRUE(map.world().level());
  EXPECT_TRUE(map.world().level()->byPlanes);
  EXPECT_NEAR(map.world().level()->tilt, 21.5, 0.7);
  const WorldMap world = readWorld(file);
  const auto upOf = [](const Pose& pose) { return -(rigidOf(pose).rotation() * cv::Vec3d(0, 1, 0)); };
  for (std::size_t i = 0; i < drive.size(); ++i) {
    ASSERT_TRUE(world.places.frames[i].pose) << i;
    const Pose& pose = *world.places.frames[i].pose;
    EXPECT_LT(std::acos(upOf(pose)[2]) - std::acos(upOf(*drive.frame(i).pose)[2]), 0.5 * CV_PI / 180) << i;
    EXPECT_NEAR(pose.z, 0, 0.03) << i << " stays on the floor";
    EXPECT_EQ(distanceBetween(pose, *map.world().odometry()->poses[i]), 0) << i;
  }
  ASSERT_TRUE(world.plan);
  EXPECT_EQ(world.plan->floor.up(), cv::Vec3d(0, 0, 1));
  // The camera is 1.2 m above the floor.
  ASSERT_FALSE(world.objects.empty());
  for (const WorldObject& object : world.objects) {
    const double bottom = object.center.z - object.size.z / 2;
    EXPECT_TRUE(object.support != Support::floor || std::abs(bottom + 1.2) < 0.1) << bottom;
  }
}

TEST(SelfTracking, GoesOnToTheLastBitWhereverItWasStopped) {
  const ScratchFolder folder;
  Drive drive(tilted(turnAround(30, 8)), 1);
  drive.noDepthValues = {5, 6};
  drive.covered = {12, 13, 14};
  drive.noDepthFile = {20};
  const fs::path unbroken = folder / "unbroken.estancia", broken = folder / "broken.estancia";
  mapAll(drive, unbroken);
  bool finished = false;
  for (const std::size_t stop : {2U, 13U, 31U}) {
    TrackedMap map(drive, broken);
    map.addUpTo(stop);
    if (finished)
      map.finish();
    else
      map.session().finish();  // all that a killed process leaves
    finished = !finished;
  }
  mapAll(drive, broken);
  EXPECT_TRUE(contentOf(broken) == contentOf(unbroken));
}

TEST(SelfTracking, KeepsWhatWasSeenWhereTheCameraFindsItsPlaceLater) {
  const ScratchFolder folder;
  std::vector<Pose> path;
  for (const Pose& pose : turnAround(40)) path.push_back(pose);
  path.erase(path.begin() + 12, path.begin() + 22);  // it is carried, then turns until it is back
  const std::vector<Pose> once = turnAround(40);
  path.insert(path.end(), once.begin(), once.begin() + 12);
  const Drive drive(path);
  const fs::path file = folder / "room.estancia";
  TrackedMap map(drive, file);
  map.addUpTo(20);
  EXPECT_FALSE(map.session().map().frames[16].pose) << "nobody can know";
  map.addUpTo(drive.size());
  map.finish();
  const WorldMap world = readWorld(file);
  EXPECT_TRUE(world.places.frames[16].pose);
  EXPECT_LT(errorOf(*map.world().odometry(), drive), 0.03);
  EXPECT_EQ(sqlite::Database(file, sqlite::Database::Mode::read)
                .number("SELECT count(*) FROM observations WHERE frame BETWEEN 12 AND 18"),
            7);
}

TEST(SelfTracking, NamesFramesThatAreWrongAndADarkCameraFillsNoFile) {
  const ScratchFolder folder;
  Drive drive(turnAround(30, 8));
  drive.noDepthFile = {4};
  for (std::size_t i = 10; i < 16; ++i) drive.covered.insert(i);
  const fs::path file = folder / "room.estancia";
  TrackedMap map(drive, file);
  map.addUpTo(drive.size());
  map.finish();
  const RgbdTrajectory& found = *map.world().odometry();
  std::set<std::size_t> named;
  for (const auto& frames : {found.lost, found.bridged})
    for (const auto& [frame, why] : frames) {
      named.insert(frame);
      EXPECT_FALSE(why.empty());
    }
  for (const std::size_t wrong : {4U, 10U, 15U}) EXPECT_TRUE(named.contains(wrong)) << wrong;
  EXPECT_LE(observationsOf(file), drive.size() - 6);
}

TEST(SelfTracking, RefusesAMapThatWasMadeInAnotherWay) {
  const ScratchFolder folder;
  const Drive drive(turnAround(30, -20));
  const fs::path file = folder / "tracked.estancia";
  {
    TrackedMap map(drive, file);
    map.addUpTo(6);
    map.finish();
  }
  WorldOptions other = manyCorrections();
  other.odometry.maxDepth = 3;
  EXPECT_THAT([&] { TrackedMap(drive, file, other); }, FailsWith(ErrorCode::mismatch));
  CameraIntrinsics zoomed = *drive.intrinsics();
  zoomed.fx *= 2;
  EXPECT_THAT([&] { TrackedMap(drive, file, manyCorrections(), zoomed); }, FailsWith(ErrorCode::mismatch));

  const OneWordLabeler labeler;
  const LexicalDescriptor words = wordsByHeading(drive).describe(0);
  const auto begin = [&](const fs::path& path, const std::optional<Pose>& pose) {
    MappingSession session = MappingSession::create(path, labeler.vocabulary(), "test", {});
    WorldMapper world(session, manyCorrections());
    Frame frame = drive.frame(0);
    frame.pose = pose;
    frame.pose = world.observe(frame, words, {}, drive.depth(0), *drive.intrinsics());
    session.add(frame, words);
    session.finish();
    world.finish();
  };
  {
    MappingSession session = MappingSession::resume(file, labeler.vocabulary(), "test");
    WorldMapper world(session);
    EXPECT_THAT([&] { world.observe(drive.frame(6), words, {}, drive.depth(6), *drive.intrinsics()); },
                FailsWith(ErrorCode::mismatch));
  }
  begin(folder / "posed.estancia", drive.frame(0).pose);
  EXPECT_THAT([&] { TrackedMap(drive, folder / "posed.estancia"); }, FailsWith(ErrorCode::mismatch));
  begin(folder / "unposed.estancia", std::nullopt);
  TrackedMap map(drive, folder / "unposed.estancia");
  map.addUpTo(3);
  map.finish();
  EXPECT_FALSE(map.world().odometry()) << "its first frames were not tracked";
}

TEST(SelfTracking, IsForDrivesWithDepthAndACameraButNoPoses) {
  Drive drive(turnAround(30, -20));
  EXPECT_FALSE(cameraToTrack(drive, {})) << "it has poses";
  Drive unposed(turnAround(30, -20));
  unposed.forgetPoses();
  EXPECT_TRUE(cameraToTrack(unposed, {}));
  WorldOptions flat;
  flat.layers = layersFrom("places,zones");
  EXPECT_FALSE(cameraToTrack(unposed, flat));
  unposed.depthKnown = false;
  EXPECT_FALSE(cameraToTrack(unposed, {}));
  unposed.depthKnown = true;
  unposed.forgetCamera();
  EXPECT_FALSE(cameraToTrack(unposed, {}));
}

}  // namespace
}  // namespace estancia
