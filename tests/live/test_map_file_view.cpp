// A map at rest: read again when its file changes; corrections are kept.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/map_file_view.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "estancia/world_file/edit_rules.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::ScratchFolder;

class MapAtRest : public testing::Test {
 protected:
  void SetUp() override { test::writeWorld(test::sampleWorld(), file_); }
  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "home.estancia";
};

TEST_F(MapAtRest, ShowsTheMapAndItsChanges) {
  const MapFileView view(file_);
  EXPECT_EQ(view.world()->areas.size(), 4U);
  EXPECT_FALSE(view.objectImage(1).empty());
  EXPECT_TRUE(view.objectImage(2).empty());
  EXPECT_THAT([&] { view.changes({}); }, FailsWith(ErrorCode::insufficientData)) << "of one drive";
  const LiveStatus before = view.status();
  EXPECT_EQ(before.source, "home.estancia");
  EXPECT_TRUE(before.places.empty());
  EXPECT_EQ(view.waitForChange(before.revision, std::chrono::milliseconds(1)).revision, before.revision);

  std::thread somebody([&] { nameArea(file_, "1", "spa"); });
  const LiveStatus after = view.waitForChange(before.revision, std::chrono::seconds(60));
  somebody.join();
  EXPECT_GT(after.mapRevision, before.mapRevision);
  EXPECT_EQ(view.world()->areas[1].givenName, "spa");
}

TEST_F(MapAtRest, KeepsCorrections) {
  MapFileView view(file_);
  const std::uint64_t before = view.status().mapRevision;
  view.edit(NameArea{1, "spa"});
  EXPECT_EQ(view.world()->areas[1].givenName, "spa");
  EXPECT_GT(view.status().mapRevision, before);
  EXPECT_EQ(readWorld(file_).areas[1].givenName, "spa");
  view.edit(NameObject{3, "Ana's umbrella"});
  EXPECT_EQ(view.world()->objects[3].givenName, "Ana's umbrella");
  view.edit(DeleteObject{0});
  EXPECT_EQ(view.world()->objects.size(), 5U);
  EXPECT_EQ(readWorld(file_).objects.size(), 5U);
}

TEST_F(MapAtRest, MergesAreasForGood) {
  MapFileView view(file_);
  view.edit(NameArea{0, "kitchen of Ana"});
  const std::uint64_t before = view.status().mapRevision;
  view.edit(MergeAreas{0, 1});
  EXPECT_GT(view.status().mapRevision, before);
  for (const WorldMap& world : {*view.world(), readWorld(file_), *MapFileView(file_).world()}) {
    EXPECT_EQ(world.areas.size(), 3U);
    const int kitchen = areaAt(*world.plan, {1, 1}, 0);
    EXPECT_EQ(areaAt(*world.plan, {5, 1}, 0), kitchen);
    EXPECT_EQ(world.findArea(kitchen)->displayName(), "kitchen of Ana");
    EXPECT_EQ(world.objects.at(5).area, kitchen) << "what was in the bathroom";
  }
}

TEST_F(MapAtRest, KeepsNothingOfWhatItRefuses) {
  MapFileView view(file_);
  const std::vector<std::pair<MapEdit, ErrorCode>> refused{
      {NameArea{99, "spa"}, ErrorCode::unknownName},
      {NameArea{0, "17"}, ErrorCode::invalidInput},
      {MergeAreas{1, 2}, ErrorCode::invalidInput},  // a wall lies between them
      {MergeAreas{2, 2}, ErrorCode::invalidInput},
      {MergeAreas{0, 99}, ErrorCode::unknownName},
      {SplitArea{{90, 90}, {91, 91}}, ErrorCode::invalidInput},
      {SplitArea{{7, 4}, {7, 4}}, ErrorCode::invalidInput},
      {DeleteObject{77}, ErrorCode::unknownName}};
  for (const auto& [edit, code] : refused)
    EXPECT_THAT(([&, &edit = edit] { view.edit(edit); }), FailsWith(code)) << edit.index();
  EXPECT_TRUE(view.status().troubles.empty());
  for (const WorldMap& world : {*view.world(), readWorld(file_)}) {
    EXPECT_EQ(world.areas.size(), 4U);
    EXPECT_EQ(world.edits.size(), test::sampleWorld().edits.size()) << "nothing is kept of what was refused";
  }
  EXPECT_THAT([&] { MapFileView(folder_ / "none.estancia"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(MapAtRest, AFileThatIsDamagedMeanwhileIsATroubleNotTheEnd) {
  const MapFileView view(file_);
  test::writeFile(file_, "no map any more");
  const LiveStatus status = view.status();
  EXPECT_EQ(status.troubles.size(), 1U);
  EXPECT_EQ(view.world()->areas.size(), 4U) << "what was read before";
  std::filesystem::remove(file_);
  EXPECT_EQ(view.status().troubles.size(), 1U);
  test::writeWorld(test::sampleWorld(), file_);
  EXPECT_TRUE(view.status().troubles.empty());
}

}  // namespace
}  // namespace estancia
