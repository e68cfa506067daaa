// Edits of areas; and recorded drives: mapped in one call, brought together by depth, and poses that jump.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/edit_rules.hpp"

#include <gmock/gmock.h>

#include "estancia/core/pose.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/world/drive_faults.hpp"
#include "estancia/world/map_sequence.hpp"
#include "estancia/world/register_drive.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/map_drive.hpp"
#include "support/room.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::FlatDrive;
using test::sampleWorld;
using test::ScratchFolder;
using Existing = MapSequenceOptions::Existing;

/// Maps the drive's frames up to `end`, beginning or going on.
void mapFlat(std::size_t end, const fs::path& file) {
  const FlatDrive drive;
  test::mapUpTo(drive, drive.labeled(), end, file);
}

constexpr std::size_t framesOfFlat = 64;

TEST(EditAreas, NamesMergesAndSplitsOutliveAnotherSegmentation) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  mapFlat(50, file);
  const std::string bedroom = "Ana's \"room\"";
  nameArea(file, "0", "hall");
  nameArea(file, std::to_string(readWorld(file).areaOfFrame[0]), bedroom);
  mapFlat(framesOfFlat, file);
  WorldMap world = readWorld(file);
  EXPECT_EQ(world.findArea(world.areaOfFrame[0])->displayName(), bedroom);

  mergeAreas(file, bedroom, std::to_string(world.areaOfFrame[20]));
  world = readWorld(file);
  EXPECT_EQ(world.areas.size(), 2U);
  EXPECT_EQ(world.areaOfFrame[0], world.areaOfFrame[20]);

  splitArea(file, {2, 0.2}, {2, 3.8});
  world = readWorld(file);
  EXPECT_EQ(world.areas.size(), 3U);
  EXPECT_NE(areaAt(*world.plan, {1, 2}, 0.1), areaAt(*world.plan, {3, 2}, 0.1));
  mapFlat(framesOfFlat, file);  // finds them anew, with all edits
  const WorldMap again = readWorld(file);
  EXPECT_EQ(again.areaOfFrame, world.areaOfFrame);
  EXPECT_EQ(cv::norm(again.plan->areaOf, world.plan->areaOf, cv::NORM_INF), 0);
  for (std::size_t i = 0; i < world.areas.size(); ++i) {
    EXPECT_EQ(again.areas[i].displayName(), world.areas[i].displayName());
    EXPECT_EQ(again.areas[i].name, world.areas[i].name) << "by the same words";
  }
}

TEST(EditAreas, RefuseWhatCannotBeDone) {
  const ScratchFolder folder;
  const fs::path file = folder / "home.estancia";
  test::writeWorld(sampleWorld(), file);
  nameArea(file, "0", "Workshop");
  for (const char* name : {" ", "\t\n", "12", " 7 ", "-3", "workshop", " Workshop"})
    EXPECT_THAT([&] { nameArea(file, "1", name); }, FailsWith(ErrorCode::invalidInput)) << name;
  EXPECT_THAT([&] { nameArea(file, "cellar", "x"); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { mergeAreas(file, "0", "0"); }, FailsWith(ErrorCode::invalidInput));
  for (const auto& line : {std::pair<cv::Point2d, cv::Point2d>{{50, 50}, {51, 51}},
                           {{1e300, 1e300}, {1e300, 1e300}},
                           {{2, 2}, {2, 2}}})
    EXPECT_THAT([&] { splitArea(file, line.first, line.second); }, FailsWith(ErrorCode::invalidInput))
        << line.first;
  nameArea(file, "0", "workshop");  // its own name in another case
  nameArea(file, "1", "room 12");
  EXPECT_EQ(readWorld(file).areas[0].displayName(), "workshop");
  EXPECT_EQ(readWorld(file).areas[1].displayName(), "room 12");
  nameArea(file, "1", "");
  EXPECT_EQ(readWorld(file).areas[1].givenName, "");
}

TEST(EditAreas, MergeOnlyWhatTouches) {
  const ScratchFolder folder;
  const fs::path file = folder / "home.estancia";
  test::writeWorld(sampleWorld(), file);
  EXPECT_THAT([&] { mergeAreas(file, "0", "3"); }, FailsWith(ErrorCode::invalidInput));
  mergeAreas(file, "0", "1");
  const WorldMap merged = readWorld(file);
  EXPECT_EQ(merged.areas.size(), 3U);
  const int kitchen = areaAt(*merged.plan, {1, 1}, 0);
  EXPECT_EQ(areaAt(*merged.plan, {5, 1}, 0), kitchen);
  EXPECT_EQ(merged.objects[0].area, kitchen);
  EXPECT_EQ(merged.objects[5].area, kitchen) << "what was in the bathroom";
  EXPECT_EQ(merged.objects[3].area, areaAt(*merged.plan, {7, 7}, 0));
  EXPECT_EQ(merged.objects[1].onObject, 0);
  EXPECT_EQ(merged.objects[1].words.size(), 2U) << "nothing else has changed";
}

TEST(EditAreas, StopWhenAsked) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  mapFlat(framesOfFlat, file);
  const std::vector<int> before = readWorld(file).areaOfFrame;
  requestInterrupt();
  EXPECT_THAT([&] { splitArea(file, {2, 0.2}, {2, 3.8}); }, FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
  EXPECT_TRUE(readWorld(file).edits.empty());
  EXPECT_EQ(readWorld(file).areaOfFrame, before);
}

TEST(MapSequence, MakesTheMapThatIsMadeFrameByFrame) {
  const ScratchFolder folder;
  const FlatDrive drive;
  RecordedLabeler words(drive.labeled());
  const MappedSequence done = mapSequence(drive, words, folder / "one.estancia");
  EXPECT_EQ(done.frames, drive.size());
  EXPECT_EQ(done.newFrames, drive.size());
  EXPECT_TRUE(done.problems.empty());
  test::mapUpTo(drive, drive.labeled(), drive.size(), folder / "many.estancia");
  const WorldMap one = readWorld(folder / "one.estancia"), many = readWorld(folder / "many.estancia");
  EXPECT_EQ(one.places.nodes.size(), many.places.nodes.size());
  EXPECT_EQ(one.areaOfFrame, many.areaOfFrame);
  EXPECT_EQ(one.areas.size(), 3U);
}

TEST(MapSequence, RefusesReplacesAndChangesOptions) {
  const ScratchFolder folder;
  const FlatDrive drive;
  RecordedLabeler words(drive.labeled());
  mapSequence(drive, words, folder / "home.estancia");
  EXPECT_THAT([&] { mapSequence(drive, words, folder / "home.estancia"); }, FailsWith(ErrorCode::fileExists));
  DescriptorSequence ofAnother = drive.labeled();
  for (Frame& frame : ofAnother.frames) frame.name += " of another drive";
  RecordedLabeler strange(ofAnother);
  EXPECT_THAT([&] { mapSequence(drive, strange, folder / "none.estancia"); },
              FailsWith(ErrorCode::fileUnreadable));
  MapSequenceOptions options;
  options.existing = Existing::replace;
  options.changeMapper = [](MapperOptions& mapper) { mapper.distance = "hellinger"; };
  options.changeWorld = [](WorldOptions& world) { world.layers = WorldLayers{.areas = false}; };
  mapSequence(drive, words, folder / "home.estancia", options);
  const WorldMap world = readWorld(folder / "home.estancia");
  EXPECT_EQ(world.places.distance, "hellinger");
  EXPECT_TRUE(world.areas.empty());
}

/// Asks to stop at the tenth frame.
class Impatient : public Progress {
 public:
  void advance(std::size_t count) override {
    if ((done_ += count) == 10) requestInterrupt();
  }

 private:
  std::size_t done_ = 0;
};

TEST(MapSequence, KeepsWhatAnInterruptedRunHasMappedAndGoesOn) {
  const ScratchFolder folder;
  const FlatDrive drive;
  RecordedLabeler words(drive.labeled());
  Impatient impatient;
  EXPECT_THAT([&] { mapSequence(drive, words, folder / "home.estancia", {}, impatient); },
              FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
  EXPECT_EQ(readMap(folder / "home.estancia").frames.size(), 10U);
  EXPECT_EQ(mapSequence(drive, words, folder / "home.estancia", {.existing = Existing::resume}).newFrames,
            drive.size() - 10);
  mapSequence(drive, words, folder / "whole.estancia");
  EXPECT_EQ(readWorld(folder / "home.estancia").areaOfFrame,
            readWorld(folder / "whole.estancia").areaOfFrame);
}

const CameraIntrinsics camera{160, 120, 130, 130, 79.5, 59.5};
/// On the floor.
cv::Affine3d moved(double x, double y, double turn) {
  return {cv::Vec3d(0, 0, turn), cv::Vec3d(x, y, 0)};
}
const cv::Affine3d elsewhere = moved(7, -3, 2.1);

struct Seen {
  std::vector<Observation> observations;
  std::vector<ObservationPose> map, drive;
};

/// A turn in the room, and another one from half a meter beside, with a Kinect's noise.
Seen twoTurns(const cv::Affine3d& driveFrame) {
  Seen seen;
  const auto add = [&](const Pose& pose) {
    const test::RoomView view =
        test::render(pose, camera, 1, static_cast<unsigned>(seen.observations.size()));
    seen.observations.push_back(observe(view.depth, camera));
    return ObservationPose{seen.observations.size() - 1, rigidOf(pose)};
  };
  for (const Pose& pose : test::turnAround(24)) seen.map.push_back(add(pose));
  for (Pose pose : test::turnAround(20)) {
    pose.x += 0.4;
    pose.y += 0.3;
    ObservationPose at = add(pose);
    at.pose = driveFrame.inv() * at.pose;
    seen.drive.push_back(at);
  }
  return seen;
}

TEST(RegisterDrive, FindsTheFrameOfADriveFromARoughGuess) {
  const Seen seen = twoTurns(elsewhere);
  const auto observation = [&](std::size_t frame) { return seen.observations[frame]; };
  const cv::Affine3d guess = moved(0.25, -0.2, 0.1) * elsewhere;
  const auto found = registerDrive(seen.drive, seen.map, observation, guess);
  ASSERT_TRUE(found);
  const cv::Affine3d error = *found * elsewhere.inv();
  EXPECT_LT(cv::norm(error * cv::Vec3d(2, 2, 0) - cv::Vec3d(2, 2, 0)), 0.03);
  EXPECT_LT(angleOf(error), 0.02);
}

TEST(RegisterDrive, FindsNothingWhereDepthDoesNotConfirm) {
  const Seen seen = twoTurns(elsewhere);
  const auto observation = [&](std::size_t frame) { return seen.observations[frame]; };
  EXPECT_FALSE(registerDrive(seen.drive, seen.map, observation, moved(40, 0, 0) * elsewhere));
  // A quarter turn: the room is 5 m long and 4 m wide.
  EXPECT_FALSE(registerDrive(seen.drive, seen.map, observation, moved(0, 0, 1.57) * elsewhere));
}

/// Which poses along x [m] are believed, '+', of frames that are so many seconds apart, if that is known.
std::string believed(const std::vector<double>& path, std::optional<double> seconds) {
  PoseJumps jumps;
  std::string text;
  for (std::size_t i = 0; i < path.size(); ++i) {
    Frame frame;
    frame.name = std::to_string(i);
    if (seconds) frame.timestamp = static_cast<double>(i) * *seconds;
    text += jumps.add(i, frame, Pose::planar(path[i], 0, 0)) ? '+' : '-';
  }
  return text;
}

TEST(PoseJumps, AreFarFromWhereTheCameraWas) {
  EXPECT_EQ(believed({0, .1, .2, 100.3, .4, .5}, 0.1), "+++-++") << "there and back";
  EXPECT_EQ(believed({0, .1, .2, 3.3, .4, .5}, 0.1), "++++++") << "not twenty times as far as before";
  EXPECT_EQ(believed({0, .1, .2, 100, 100, 100.1, 100.2}, 0.1), "+++--++") << "it goes on from there";
  EXPECT_EQ(believed({0, .1, .2, 100, 300, 900, .6}, 0.1), "+++---+") << "each time elsewhere";
}

TEST(PoseJumps, AreNoneWhereTheCameraWasAsFastBeforeOrHadTheTime) {
  EXPECT_EQ(believed({0, 3, 6, 9, 12, 15}, 0.1), "++++++");
  EXPECT_EQ(believed({0, 0, 0, 0, 0, 8}, 60.0), "++++++");
  EXPECT_EQ(believed({0, 0, 0, 0, 0, 8}, {}), "++++++") << "the next room";
  EXPECT_EQ(believed({0, 0, 0, 0, 0, 20}, {}), "+++++-");
}

}  // namespace
}  // namespace estancia
