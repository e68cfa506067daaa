// A map at rest: read again when its file changes; corrections are kept.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/map_file_view.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "estancia/world/edit_areas.hpp"
#include "support/errors.hpp"
#include "support/sample_world.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::ScratchFolder;

TEST(MapFileView, ShowsTheMapAndItsChanges) {
  const ScratchFolder folder;
  const auto file = folder / "home.estancia";
  test::writeWorld(test::sampleWorld(), file);
  const MapFileView view(file);
  EXPECT_EQ(view.world()->areas.size(), 4U);
  EXPECT_FALSE(view.objectImage(1).empty());
  EXPECT_TRUE(view.objectImage(2).empty());
  const LiveStatus before = view.status();
  EXPECT_EQ(before.source, "home.estancia");
  EXPECT_TRUE(before.places.empty());
  EXPECT_EQ(view.waitForChange(before.revision, std::chrono::milliseconds(1)).revision, before.revision);

  std::thread somebody([&] { nameArea(file, "1", "spa"); });
  const LiveStatus after = view.waitForChange(before.revision, std::chrono::seconds(60));
  somebody.join();
  EXPECT_GT(after.mapRevision, before.mapRevision);
  EXPECT_EQ(view.world()->areas[1].givenName, "spa");
}

TEST(MapFileView, KeepsCorrections) {
  const ScratchFolder folder;
  const auto file = folder / "home.estancia";
  test::writeWorld(test::sampleWorld(), file);
  MapFileView view(file);
  const std::uint64_t before = view.status().mapRevision;
  view.edit(NameArea{1, "spa"});
  EXPECT_EQ(view.world()->areas[1].givenName, "spa");
  EXPECT_GT(view.status().mapRevision, before);
  EXPECT_EQ(readWorld(file).areas[1].givenName, "spa");
  EXPECT_THAT([&] { view.edit(NameArea{99, "spa"}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { view.edit(NameArea{0, "17"}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { view.edit(MergeAreas{0, 0}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { view.edit(SplitArea{{90, 90}, {91, 91}}); }, FailsWith(ErrorCode::invalidInput));
}

TEST(MapFileView, KeepsCorrectionsOfObjects) {
  const ScratchFolder folder;
  const auto file = folder / "home.estancia";
  test::writeWorld(test::sampleWorld(), file);
  MapFileView view(file);
  view.edit(NameObject{3, "Ana's umbrella"});
  EXPECT_EQ(view.world()->objects[3].givenName, "Ana's umbrella");
  view.edit(DeleteObject{0});
  EXPECT_EQ(view.world()->objects.size(), 5U);
  EXPECT_EQ(readWorld(file).objects.size(), 5U);
  EXPECT_THAT([&] { view.edit(DeleteObject{77}); }, FailsWith(ErrorCode::unknownName));
}

TEST(MapFileView, AFileThatIsDamagedMeanwhileIsATroubleNotTheEnd) {
  const ScratchFolder folder;
  const auto file = folder / "home.estancia";
  test::writeWorld(test::sampleWorld(), file);
  const MapFileView view(file);
  test::writeFile(file, "no map any more");
  const LiveStatus status = view.status();
  EXPECT_EQ(status.troubles.size(), 1U);
  EXPECT_EQ(view.world()->areas.size(), 4U) << "what was read before";
  std::filesystem::remove(file);
  EXPECT_EQ(view.status().troubles.size(), 1U);
  test::writeWorld(test::sampleWorld(), file);
  EXPECT_TRUE(view.status().troubles.empty());
}

TEST(MapFileView, NeedsAMapAtFirst) {
  const ScratchFolder folder;
  EXPECT_THAT([&] { MapFileView(folder / "none.estancia"); }, FailsWith(ErrorCode::fileNotFound));
}

}  // namespace
}  // namespace estancia
