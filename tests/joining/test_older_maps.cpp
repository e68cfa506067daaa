// Maps of earlier versions: their files can be read, asked and continued.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "estancia/joining/merge_maps.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/map_sequence.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "estancia/world_query/ask_world.hpp"
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

/// `PRAGMA user_version`.
int formatOf(const fs::path& file) {
  sqlite3* database = nullptr;
  sqlite3_stmt* statement = nullptr;
  EXPECT_EQ(sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  EXPECT_EQ(sqlite3_prepare_v2(database, "PRAGMA user_version", -1, &statement, nullptr), SQLITE_OK);
  EXPECT_EQ(sqlite3_step(statement), SQLITE_ROW);
  const int version = sqlite3_column_int(statement, 0);
  sqlite3_finalize(statement);
  sqlite3_close(database);
  return version;
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

}  // namespace
}  // namespace estancia
