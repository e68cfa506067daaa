// Maps of older programs, and maps that keep a bounded number of frames.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "estancia/core/pose.hpp"
#include "estancia/joining/merge_maps.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/query/drives.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/map_sequence.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_file/observation.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/changes.hpp"
#include "support/flat_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::ScratchFolder;

/// A file of tests/maps (how it was made: README.md there) and its contents.
struct OlderMap {
  std::string name;
  int format;
  std::size_t frames, nodes, drives, areas, objects;
  /// Whether frames of the last drive have poses.
  bool posesAreKnown;
};

void PrintTo(const OlderMap& map, std::ostream* out) {
  *out << map.name;
}

fs::path fileOf(const OlderMap& map) {
  return fs::path(ESTANCIA_SOURCE_DIR) / "tests/maps" / (map.name + ".estancia");
}

std::int64_t formatOf(const fs::path& file) {
  return sqlite::Database(file, sqlite::Database::Mode::read).number("PRAGMA user_version");
}

/// A drive by the camera of debian/tests/make-drive, which sees nothing: its poses are for the odometry to
/// find.
class DarkDrive : public test::FlatDrive {
 public:
  DarkDrive() {
    intrinsics_ = CameraIntrinsics{160, 120, 150, 150, 80, 60};
    for (Frame& frame : frames_) frame.pose.reset();
  }
  cv::Mat image(std::size_t) const override { return {120, 160, CV_8UC3, cv::Scalar()}; }
  cv::Mat depth(std::size_t) const override { return {120, 160, CV_32F, cv::Scalar(0)}; }
};

class OlderMaps : public testing::TestWithParam<OlderMap> {};

TEST_P(OlderMaps, AreReadAndAsked) {
  EXPECT_EQ(formatOf(fileOf(GetParam())), GetParam().format);
  const WorldMap world = readWorld(fileOf(GetParam()));
  EXPECT_EQ(world.places.frames.size(), GetParam().frames);
  EXPECT_EQ(world.places.nodes.size(), GetParam().nodes);
  EXPECT_EQ(world.places.drives.size(), GetParam().drives);
  EXPECT_EQ(world.areas.size(), GetParam().areas);
  EXPECT_EQ(world.objects.size(), GetParam().objects);
  EXPECT_EQ(world.places.frames.back().pose.has_value(), GetParam().posesAreKnown);
  const test::WithoutWordNet names;
  const WorldAnswers answers = askWorld(world, "stove");
  ASSERT_FALSE(answers.places.empty());
  EXPECT_EQ(bestLabels(world.places.getNode(answers.places.front().node), 1), (std::vector<std::size_t>{0}));
}

TEST_P(OlderMaps, GoOnWithAnotherDrive) {
  const ScratchFolder folder;
  const fs::path file = folder / "map.estancia";
  fs::copy_file(fileOf(GetParam()), file);
  const WorldMap before = readWorld(file);
  const bool isTracked = GetParam().name.starts_with("tracked");
  const std::unique_ptr<test::FlatDrive> made(isTracked ? new DarkDrive() : new test::FlatDrive());
  test::FlatDrive& drive = *made;
  drive.frames_.resize(6);
  DescriptorSequence labeled = drive.labeled();
  labeled.vocabulary = before.places.vocabulary;
  labeled.model = before.places.model;
  RecordedLabeler labeler(labeled);
  MapSequenceOptions options;
  options.existing = MapSequenceOptions::Existing::resume;
  const MappedSequence mapped = mapSequence(drive, labeler, file, options);
  EXPECT_EQ(mapped.newFrames, 6U);
  const WorldMap after = readWorld(file);
  EXPECT_EQ(formatOf(file), 6);
  EXPECT_EQ(after.places.drives.size(), before.places.drives.size() + 1);
  ASSERT_EQ(after.places.frames.size(), before.places.frames.size() + 6);
  for (std::size_t i = 0; i < before.places.frames.size(); ++i)
    EXPECT_EQ(after.places.frames[i].name, before.places.frames[i].name) << i;
}

TEST(OptionsOfAnOlderMap, AreReportedIfTheyHaveGone) {
  const ScratchFolder folder;
  const fs::path file = folder / "map.estancia";
  fs::copy_file(fs::path(ESTANCIA_SOURCE_DIR) / "tests/maps/options-6.estancia", file);
  const WorldMap before = readWorld(file);
  const auto areReported =
      testing::ElementsAre(testing::ContainsRegex("mapper.nearer-than-current.*true.*was false"),
                           testing::ContainsRegex("world.areas.word-map.cell.*0.2,.*was 0.25"),
                           testing::ContainsRegex("world.clusters.plane-tolerance.*0.01,.*was 0.012"));
  {
    MappingSession session = MappingSession::resume(file, before.places.vocabulary, before.places.model);
    EXPECT_THAT(WorldMapper::goneOptionsOf(session), areReported);
  }
  const std::vector<fs::path> maps{file, fs::path(ESTANCIA_SOURCE_DIR) / "tests/maps/tracked-6.estancia"};
  EXPECT_THAT(mergeMaps(maps, folder / "merged.estancia").conflicts, areReported);
  EXPECT_THAT(undoDrive(file, 1), areReported);
}

INSTANTIATE_TEST_SUITE_P(Formats, OlderMaps,
                         testing::Values(OlderMap{"places-4", 4, 40, 3, 1, 0, 0, false},
                                         OlderMap{"poses-4", 4, 28, 2, 1, 0, 0, true},
                                         OlderMap{"places-5", 5, 40, 3, 1, 0, 0, false},
                                         OlderMap{"depth-5", 5, 28, 2, 1, 2, 3, true},
                                         OlderMap{"tracked-5", 5, 12, 1, 1, 1, 1, true},
                                         OlderMap{"places-6", 6, 40, 3, 1, 0, 0, false},
                                         OlderMap{"depth-6", 6, 28, 2, 1, 2, 3, true},
                                         OlderMap{"tracked-6", 6, 12, 12, 1, 1, 1, true},
                                         OlderMap{"drives-6", 6, 56, 2, 2, 2, 3, false},
                                         OlderMap{"merged-6", 6, 56, 2, 2, 2, 3, false},
                                         OlderMap{"options-6", 6, 56, 2, 2, 2, 3, false}));

/// A flat that is seen with depth in the first round, and driven through many times after.
class BoundedMap : public testing::Test {
 protected:
  void map(std::size_t rounds, const MapBudget& budget, const std::string& name = "") {
    const bool isNew = !fs::exists(file_);
    MappingSession session =
        isNew ? MappingSession::create(file_, labeled_.vocabulary, labeled_.model, MapperOptions{})
              : MappingSession::resume(file_, labeled_.vocabulary, labeled_.model);
    session.setBudget(budget);
    if (!isNew) session.beginDrive({name, name, true});
    WorldMapper world(session);
    if (!isNew) world.beginDrive();
    for (std::size_t round = 0; round < rounds; ++round)
      for (std::size_t i = 0; i < drive_.size(); ++i) {
        Frame frame = drive_.frame(i);
        frame.name = std::to_string(round) + " " + frame.name;
        if (round == 0)
          world.observe(frame, labeled_.descriptors.row(i), drive_.image(i), drive_.depth(i),
                        *drive_.intrinsics());
        else
          world.observe(frame, labeled_.descriptors.row(i), std::nullopt);
        session.add(frame, labeled_.descriptors.row(i));
      }
    session.finish();
    world.finish();
  }

  /// Drives on in a frame of its own.
  void driveTurned(std::size_t rounds) {
    const cv::Affine3d own(cv::Vec3d(0, 0, 1.2), cv::Vec3d(3, -2, 0));
    MappingSession session = MappingSession::resume(file_, labeled_.vocabulary, labeled_.model);
    session.beginDrive({"turned", "turned"});
    WorldMapper world(session);
    for (std::size_t round = 0; round < rounds; ++round)
      for (std::size_t i = 0; i < drive_.size(); ++i) {
        Frame frame = drive_.frame(i);
        frame.name = "turned " + std::to_string(round) + " " + frame.name;
        frame.pose = poseOf(own.inv() * rigidOf(*frame.pose));
        frame.pose = world.observe(frame, labeled_.descriptors.row(i), {}, {}, {});
        session.add(frame, labeled_.descriptors.row(i));
      }
    session.finish();
    world.finish();
  }

  /// What its area is called in a map that keeps all frames, by the room of a frame.
  static std::map<std::string, std::set<int>> areasOfRooms(const WorldMap& world) {
    std::map<std::string, std::set<int>> areas;
    for (std::size_t i = 0; i < world.places.frames.size(); ++i)
      if (world.areaOfFrame[i] >= 0) areas[world.places.frames[i].room].insert(world.areaOfFrame[i]);
    return areas;
  }

  const test::ScratchFolder folder_;
  const fs::path file_ = folder_ / "flat.estancia";
  const test::FlatDrive drive_;
  const DescriptorSequence labeled_ = drive_.labeledInWords();
};

constexpr std::size_t manyRounds = 250;

TEST_F(BoundedMap, HasTheAreasAndCorrectionsOfAWholeOneAndTakesFurtherDrives) {
  map(1, {});
  const auto areas = areasOfRooms(readWorld(file_));
  ASSERT_EQ(areas.size(), 3U);
  fs::remove(file_);
  MapBudget budget;
  budget.file = 2;
  map(manyRounds, budget);
  EXPECT_LE(fs::file_size(file_), 2'200'000U);
  const WorldMap world = readWorld(file_);
  EXPECT_TRUE(world.places.isThinned());
  EXPECT_LT(world.places.frames.size(), manyRounds * drive_.size() * 2 / 3);
  EXPECT_EQ(world.areas.size(), 3U);
  ASSERT_EQ(world.areaOfFrame.size(), world.places.frames.size());
  const auto bounded = areasOfRooms(world);
  for (const auto& [room, numbers] : bounded) EXPECT_EQ(numbers.size(), areas.at(room).size()) << room;
  const fs::path whole = folder_ / "whole.estancia";
  fs::copy_file(file_, whole);

  const int kitchen = *bounded.at("kitchen").begin();
  nameArea(file_, std::to_string(kitchen), "galley");
  mergeAreas(file_, "galley", std::to_string(*bounded.at("corridor").begin()));
  const WorldMap corrected = readWorld(file_);
  EXPECT_EQ(corrected.areas.size(), 2U);
  const auto after = areasOfRooms(corrected);
  EXPECT_EQ(after.at("kitchen"), after.at("corridor"));
  EXPECT_NE(after.at("bedroom"), after.at("kitchen"));
  EXPECT_EQ(corrected.findArea(*after.at("kitchen").begin())->displayName(), "galley");

  fs::copy_file(whole, file_, fs::copy_options::overwrite_existing);
  driveTurned(8);
  const TopologicalMap turned = readMap(file_);
  ASSERT_EQ(turned.drives.size(), 2U);
  ASSERT_TRUE(turned.drives[1].isAligned) << "frames waited, and may be left out, until its poses were known";
  for (std::size_t i = turned.drives[1].firstFrame; i < turned.frames.size(); ++i) {
    const std::size_t seen = (turned.frames[i].number - manyRounds * drive_.size()) % drive_.size();
    ASSERT_TRUE(turned.frames[i].pose) << i;
    EXPECT_LT(distanceBetween(*turned.frames[i].pose, *drive_.frame(seen).pose), 0.5) << i;
  }

  fs::copy_file(whole, file_, fs::copy_options::overwrite_existing);
  constexpr std::size_t moreRounds = 60;
  map(moreRounds, budget, "second");
  EXPECT_LE(fs::file_size(file_), 2'200'000U);
  const TopologicalMap both = readMap(file_);
  const auto drives = summarizeDrives(both);
  ASSERT_EQ(drives.size(), 2U);
  EXPECT_EQ(drives[0].frames, manyRounds * drive_.size());
  EXPECT_EQ(drives[1].frames, moreRounds * drive_.size());
  EXPECT_LT(drives[1].kept, drives[1].frames);
  EXPECT_GT(drives[1].kept, 0U);
  EXPECT_EQ(both.nodes.size(), world.places.nodes.size()) << "the second drive is in the places of the first";
  EXPECT_TRUE(findChanges(file_, 1).objects.empty());
  undoDrive(file_, 1);
  EXPECT_EQ(readMap(file_).drives.size(), 1U);
  EXPECT_EQ(readWorld(file_).areas.size(), 3U);
  const MappingSession session = MappingSession::resume(file_, labeled_.vocabulary, labeled_.model);
  EXPECT_EQ(session.budget(), budget) << "the map keeps it";
}

TEST_F(BoundedMap, AreasKeepTheirNumbersInFurtherDrives) {
  map(1, {});
  const auto before = areasOfRooms(readWorld(file_));
  // By the number of frames, the bedroom and the kitchen would come first from now on.
  for (const std::string& room : {std::string("kitchen"), std::string("bedroom")}) {
    MappingSession session = MappingSession::resume(file_, labeled_.vocabulary, labeled_.model);
    session.beginDrive({room, room, true});
    WorldMapper world(session);
    for (int round = 0; round < (room == "kitchen" ? 6 : 4); ++round)
      for (std::size_t i = 0; i < drive_.size(); ++i) {
        Frame frame = drive_.frame(i);
        if (frame.room != room) continue;
        frame.name = room + std::to_string(round) + frame.name;
        world.observe(frame, labeled_.descriptors.row(i), std::nullopt);
        session.add(frame, labeled_.descriptors.row(i));
      }
    session.finish();
    world.finish();
    EXPECT_EQ(areasOfRooms(readWorld(file_)), before) << "after the drive in the " << room;
  }
}

TEST_F(BoundedMap, IsCompactedWithItsLayers) {
  map(manyRounds, {});
  const WorldMap whole = readWorld(file_);
  const CompactedMap done = compactMap(file_, 2);
  EXPECT_LE(done.bytesAfter, 2'000'000U);
  EXPECT_LT(done.framesAfter, done.framesBefore);
  const WorldMap world = readWorld(file_);
  EXPECT_EQ(world.areas.size(), whole.areas.size());
  EXPECT_EQ(world.objects.size(), whole.objects.size());
  for (std::size_t i = 0; i < world.places.frames.size(); ++i)
    EXPECT_EQ(world.areaOfFrame[i], whole.areaOfFrame[world.places.frames[i].number]) << i;
}

}  // namespace
}  // namespace estancia
