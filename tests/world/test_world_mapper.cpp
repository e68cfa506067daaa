// A map that keeps areas beside its places, in one pass, through interruptions and corrections.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/areas.hpp"
#include "estancia/world/world_mapper.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "estancia/core/pose.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/layers/work_time.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/map_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::FlatDrive;
using test::ScratchFolder;

/// Maps the drive's frames up to `end`, beginning or going on.
void mapUpTo(const FlatDrive& drive, std::size_t end, const fs::path& file, Labeler* labeler = nullptr) {
  test::mapUpTo(drive, drive.labeled(), end, file, labeler);
}

WorldMap mapOf(const FlatDrive& drive, const fs::path& file) {
  mapUpTo(drive, drive.size(), file);
  return readWorld(file);
}

void expectSame(const WorldMap& a, const WorldMap& b) {
  EXPECT_EQ(a.areaOfFrame, b.areaOfFrame);
  ASSERT_EQ(a.areas.size(), b.areas.size());
  for (std::size_t i = 0; i < a.areas.size(); ++i) {
    EXPECT_EQ(a.areas[i].displayName(), b.areas[i].displayName());
    EXPECT_EQ(a.areas[i].size, b.areas[i].size);
    EXPECT_EQ(a.areas[i].outline, b.areas[i].outline);
  }
  ASSERT_TRUE(a.plan && b.plan);
  EXPECT_EQ(cv::norm(a.plan->areaOf, b.plan->areaOf, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(a.plan->walls, b.plan->walls, cv::NORM_INF), 0);
}

TEST(WorldMapper, FindsTheAreasThatTheWholeDriveShows) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const WorldMap world = mapOf(drive, folder / "flat.estancia");
  ASSERT_EQ(world.areas.size(), 3U);
  std::set<std::pair<std::string, int>> pairs;
  for (std::size_t i = 0; i < drive.size(); ++i) pairs.emplace(drive.frame(i).room, world.areaOfFrame[i]);
  EXPECT_EQ(pairs.size(), 3U);
  const Areas whole = findAreas(drive, drive.labeled());
  EXPECT_EQ(world.areaOfFrame, whole.zones.zoneOf);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(world.areas[i].name, whole.areas[i].name);
}

TEST(WorldMapper, GoesOnWhereItStoppedAsIfItHadNotStopped) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const WorldMap unbroken = mapOf(drive, folder / "unbroken.estancia");
  const fs::path file = folder / "broken.estancia";
  for (const std::size_t stop : {2U, 17U, 64U}) mapUpTo(drive, stop, file);
  expectSame(readWorld(file), unbroken);
}

TEST(WorldMapper, KeepsTheLayersOfAllFramesConsistentAtAnyTime) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  for (std::size_t end = 16; end <= drive.size(); end += 16) {
    mapUpTo(drive, end, file);
    const WorldMap world = readWorld(file);
    ASSERT_EQ(world.areaOfFrame.size(), end);
    for (std::size_t i = 0; i < end; ++i) {
      ASSERT_NE(world.findArea(world.areaOfFrame[i]), nullptr) << i;
      const PlanarPose at = world.plan->floor.project(*world.places.frames[i].pose);
      EXPECT_EQ(areaAt(*world.plan, {at.x, at.y}, 0.5), world.areaOfFrame[i]) << i << " of " << end;
    }
  }
}

TEST(WorldMapper, KeepsNoMoreViewsOfADriveThatStandsOrGoesRoundAndRound) {
  const ScratchFolder folder;
  const auto viewsOf = [&folder](const FlatDrive& drive, const std::string& name) {
    mapUpTo(drive, drive.size(), folder / name);
    return sqlite::Database(folder / name, sqlite::Database::Mode::read)
        .number("SELECT count(*) FROM observations");
  };
  FlatDrive still, around;
  for (Frame& frame : still.frames_) frame.pose = still.frames_[0].pose;
  EXPECT_EQ(viewsOf(still, "still.estancia"), 1);
  const std::vector<Frame> round = around.frames_;
  for (int i = 1; i < 14; ++i) around.frames_.insert(around.frames_.end(), round.begin(), round.end());
  EXPECT_LE(viewsOf(around, "around.estancia"), 9 * static_cast<std::int64_t>(round.size()));
}

TEST(WorldMapper, HasNoAreasWithoutPosesOrDepth) {
  const ScratchFolder folder;
  FlatDrive drive;
  for (Frame& frame : drive.frames_) frame.pose.reset();
  EXPECT_TRUE(mapOf(drive, folder / "unposed.estancia").areas.empty());
  FlatDrive dark;
  dark.zero = [](std::size_t) { return true; };
  EXPECT_FALSE(mapOf(dark, folder / "dark.estancia").plan.has_value());
  EXPECT_THAT([] { observe(cv::Mat(4, 4, CV_16U), test::smallCamera()); },
              FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([] { observe(cv::Mat(4, 4, CV_32F), CameraIntrinsics{}); }, FailsWith(ErrorCode::invalidInput));
}

/// Knows a bed, but not in every image.
class MoodyLabeler : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return "test"; }
  Prepared prepare(const cv::Mat& bgr, const std::string& /*frame*/) const override { return {bgr, "", {}}; }
  LexicalDescriptor infer(const Prepared& /*image*/) override {
    if (++asked % 2 == 0) throw FrameError("not this one");
    return {0.7F, 0.1F, 0.1F, 0.1F};
  }
  std::size_t asked = 0;

 private:
  Vocabulary vocabulary_{{"bed", "stove", "doormat", "wall"}};
};

/// A parcel on the floor of an empty room, seen from all around.
class ParcelDrive : public FlatDrive {
 public:
  ParcelDrive() {
    intrinsics_ = CameraIntrinsics{160, 120, 131, 131, 79.5, 59.5};
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size());
      frames_[i].pose =
          test::lookingAt(1.6 * std::cos(angle), 1.6 * std::sin(angle), 1.2, angle + std::numbers::pi, -0.5);
    }
  }
  cv::Mat image(std::size_t) const override { return {120, 160, CV_8UC3, cv::Scalar(10, 20, 30)}; }
  cv::Mat depth(std::size_t i) const override {
    return test::boxesDepth(*frames_[i].pose, *intrinsics_, {{{{-0.25, -0.25, 0}, {0.25, 0.25, 0.5}}}});
  }
};

TEST(WorldMapper, NamesObjectsByImagesOfThemAlsoWhereSomeCannotBeLabeled) {
  const ScratchFolder folder;
  const ParcelDrive drive;
  MoodyLabeler labeler;
  const auto mapUntil = [&](std::size_t end, const fs::path& file) {
    mapUpTo(drive, end, file, &labeler);
    return readWorld(file);
  };
  const WorldMap world = mapUntil(drive.size(), folder / "parcel.estancia");
  ASSERT_EQ(world.objects.size(), 1U);
  const WorldObject& parcel = world.objects.front();
  EXPECT_EQ(parcel.displayName(), "bed");
  EXPECT_NEAR(cv::norm(parcel.center - cv::Point3d(0, 0, 0.25)), 0, 0.06);
  EXPECT_NEAR(parcel.size.z, 0.5, 0.08);
  EXPECT_EQ(parcel.support, Support::floor);
  EXPECT_EQ(parcel.area, 0);
  EXPECT_EQ(parcel.color, (std::array<int, 3>{30, 20, 10}));
  EXPECT_EQ(parcel.firstFrame, 0U);
  EXPECT_GT(labeler.asked, 10U);
  EXPECT_FALSE(readObjectImage(folder / "parcel.estancia", 0).empty());

  labeler.asked = 0;  // the interrupted drive must label the same images
  for (const std::size_t stop : {10U, 33U}) mapUntil(stop, folder / "broken.estancia");
  const WorldMap resumed = mapUntil(drive.size(), folder / "broken.estancia");
  ASSERT_EQ(resumed.objects.size(), 1U);
  EXPECT_EQ(resumed.objects.front().center, parcel.center);
  EXPECT_EQ(resumed.objects.front().probability(), parcel.probability());
  EXPECT_EQ(resumed.objects.front().views, parcel.views);
}

/// Sees stoves wherever it looks, and knows no image of them by itself.
class StoveDetector : public MoodyLabeler {
 public:
  LexicalDescriptor infer(const Prepared& /*image*/) override {
    ADD_FAILURE() << "what a detector tells of a thing that is cut out says little";
    return {};
  }
  std::vector<std::size_t> regionLabels() const override { return {1}; }
  std::vector<LexicalDescriptor> labelRegions(const cv::Mat& bgr,
                                              std::span<const cv::Rect2d> regions) override {
    EXPECT_EQ(bgr.size(), cv::Size(160, 120));
    for (const cv::Rect2d& region : regions) EXPECT_EQ(region & cv::Rect2d(0, 0, 1, 1), region);
    if (++asked % 3 == 0) throw FrameError("not this one");
    return std::vector<LexicalDescriptor>(regions.size(), {asked % 3 == 1 ? 0.9F : 0.5F});
  }
};

TEST(WorldMapper, NamesObjectsByADetectorThatSeesThemAmongOthers) {
  const ScratchFolder folder;
  const ParcelDrive drive;
  StoveDetector detector;
  const fs::path file = folder / "stove.estancia";
  for (const std::size_t end : {std::size_t{20}, drive.size()}) mapUpTo(drive, end, file, &detector);
  const auto expectStove = [&file] {
    const WorldMap world = readWorld(file);
    ASSERT_EQ(world.objects.size(), 1U);
    EXPECT_EQ(world.objects[0].displayName(), "stove");
    EXPECT_NEAR(world.objects[0].probability(), 0.7, 0.02) << "the mean";
  };
  expectStove();
  mapUpTo(drive, drive.size(), file);  // makes the layers again, without a labeler
  expectStove();
  EXPECT_FALSE(readObjectImage(file, 0).empty());
  for (const char* damage : {"segment_words SET words = x'00'", "observations SET seen = x'0011'"}) {
    sqlite::Database(file, sqlite::Database::Mode::write).run(std::string("UPDATE ") + damage);
    EXPECT_THAT([&] { mapUpTo(drive, drive.size(), file); }, FailsWith(ErrorCode::corruptFile));
  }
}

TEST(WorldMapper, DoesNotBelieveAPoseThatJumpsAwayAndBack) {
  const ScratchFolder folder;
  FlatDrive drive, spoilt;
  spoilt.frames_[9].pose->x += 30;
  spoilt.frames_[20].pose->y -= 1e6;
  const WorldMap whole = mapOf(drive, folder / "whole.estancia");
  const fs::path file = folder / "spoilt.estancia", broken = folder / "broken.estancia";
  const WorldMap world = mapOf(spoilt, file);
  EXPECT_EQ(world.areas.size(), whole.areas.size());
  EXPECT_EQ(world.plan->areaOf.size(), whole.plan->areaOf.size()) << "no floor plan reaches there";
  for (const std::size_t stop : {10U, 64U}) mapUpTo(spoilt, stop, broken);
  expectSame(readWorld(broken), world);
}

TEST(WorldMapper, CountsDepthThatShowsNothing) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const DescriptorSequence labeled = drive.labeled();
  MappingSession session =
      MappingSession::create(folder / "dark.estancia", labeled.vocabulary, labeled.model, MapperOptions{});
  WorldMapper world(session);
  const auto add = [&](const cv::Mat& depth) {
    const std::size_t i = session.frames();
    world.observe(drive.frame(i), labeled.descriptors.row(i), drive.image(i), depth, *drive.intrinsics());
    session.add(drive.frame(i), labeled.descriptors.row(i));
  };
  for (const float z : {2.0F, 0.0F, 900.0F, 0.0F}) add(cv::Mat(48, 64, CV_32F, cv::Scalar(z)));
  add({});
  EXPECT_EQ(world.faults().depthImages, 4U);
  EXPECT_EQ(world.faults().noDepth.count, 2U);
  EXPECT_EQ(world.faults().noDepth.first, "frame 1");
  EXPECT_EQ(world.faults().tooFar.count, 1U);
  EXPECT_EQ(world.faults().tooFar.first, "frame 2");
}

TEST(WorldMapper, GoesOnWithTheSameOptionsAndCamera) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  const DescriptorSequence labeled = drive.labeled();
  WorldOptions wide;
  wide.areas.cell = 0.1;
  {
    MappingSession session = MappingSession::create(file, labeled.vocabulary, labeled.model, MapperOptions{});
    EXPECT_FALSE(WorldMapper::optionsOf(session));
    WorldMapper world(session, wide);
    world.keepCamera(*drive.intrinsics(), 1000);
    world.observe(drive.frame(0), labeled.descriptors.row(0), {}, drive.depth(0), *drive.intrinsics());
    session.add(drive.frame(0), labeled.descriptors.row(0));
    session.finish();
    world.finish();
  }
  MappingSession session = MappingSession::resume(file, labeled.vocabulary, labeled.model);
  ASSERT_TRUE(WorldMapper::optionsOf(session));
  EXPECT_EQ(WorldMapper::optionsOf(session)->areas.cell, 0.1);
  EXPECT_THAT([&] { WorldMapper(session, WorldOptions{}); }, FailsWith(ErrorCode::mismatch));
  wide.segments.threads = 1;
  EXPECT_NO_THROW(WorldMapper(session, wide)) << "changes no result";
  WorldMapper world(session);
  EXPECT_NO_THROW(world.keepCamera(*drive.intrinsics(), 1000));
  CameraIntrinsics zoomed = *drive.intrinsics();
  zoomed.fx *= 2;
  EXPECT_THAT([&] { world.keepCamera(zoomed, 1000); }, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { world.keepCamera(*drive.intrinsics(), 5000); }, FailsWith(ErrorCode::mismatch));
}

TEST(WorldMapper, OpensMapsThatWereMadeWithOptionsThatHaveGone) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  mapUpTo(drive, 2, file);
  const DescriptorSequence labeled = drive.labeled();
  {
    MapStore store = MapStore::open(file, MapStore::Access::write);
    std::string terms = store.findState("world terms").value();
    const std::size_t at = terms.find("0.0022", terms.find("clusters.crease-depth"));
    ASSERT_NE(at, std::string::npos) << "older programs find what they know";
    store.putState("world terms", terms.replace(at, 6, "0.0044"));
    store.commit();
  }
  mapUpTo(drive, 4, file);
  EXPECT_EQ(readMap(file).frames.size(), 4U);
  MappingSession session = MappingSession::resume(file, labeled.vocabulary, labeled.model);
  EXPECT_THAT(WorldMapper::goneOptionsOf(session),
              testing::ElementsAre(testing::ContainsRegex("world.clusters.crease-depth.*0.0022.*0.0044")));
}

/// Depth of the drive's first frames was to confirm where it is, but the WorldMapper is destroyed first.
TEST(WorldMapper, MayGoBeforeItsSession) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  const DescriptorSequence labeled = drive.labeledInWords();
  test::mapUpTo(drive, labeled, drive.size(), file);
  MappingSession session = MappingSession::resume(file, labeled.vocabulary, labeled.model);
  session.beginDrive({"turned", "turned"});
  std::optional<WorldMapper> world(std::in_place, session);
  world->beginDrive();
  const cv::Affine3d own(cv::Vec3d(0, 0, 1.2), cv::Vec3d(3, -2, 0));
  for (int round = 0; round < 8; ++round)
    for (std::size_t i = 0; i < drive.size(); ++i) {
      Frame frame = drive.frame(i);
      frame.name = "turned " + std::to_string(round) + " " + frame.name;
      frame.pose = poseOf(own.inv() * rigidOf(*frame.pose));
      if (world)
        world->observe(frame, labeled.descriptors.row(i), drive.image(i), drive.depth(i),
                       *drive.intrinsics());
      session.add(frame, labeled.descriptors.row(i));
      world.reset();
    }
  session.finish();
  EXPECT_TRUE(readMap(file).drives.back().isAligned) << "by words";
}

/// Frames, views and labeled images of a drive of which each frame is to be done until then.
std::array<std::size_t, 3> takenUntil(const Deadline& deadline) {
  const ScratchFolder folder;
  const FlatDrive drive;
  const fs::path file = folder / "flat.estancia";
  const DescriptorSequence labeled = drive.labeled();
  MoodyLabeler labeler;
  MappingSession session = MappingSession::create(file, labeled.vocabulary, labeled.model, {});
  WorldMapper world(session, {}, &labeler);
  for (std::size_t i = 0; i < drive.size(); ++i)
    world.add(
        drive.frame(i), labeled.descriptors.row(i), drive.image(i), drive.depth(i), *drive.intrinsics(),
        [] { return std::vector<unsigned char>(); }, [](int, const std::optional<Pose>&) {}, deadline);
  session.finish();
  world.finish();
  const sqlite::Database database(file, sqlite::Database::Mode::read);
  return {session.frames(), static_cast<std::size_t>(database.number("SELECT count(*) FROM observations")),
          labeler.asked};
}

TEST(WorldMapper, LeavesEveryFrameInTheMapWithFewerViewsWhereThereIsNoTime) {
  const auto all = takenUntil({}), late = takenUntil(Deadline::value_type::min());
  EXPECT_EQ(takenUntil(Deadline::value_type::max()), all);
  EXPECT_EQ(all[1], all[0]);
  EXPECT_EQ(late[0], all[0]);
  EXPECT_GE(late[1], 1U);
  EXPECT_LE(late[1], all[1]);
  EXPECT_LE(late[2], all[2]);
}

}  // namespace
}  // namespace estancia
