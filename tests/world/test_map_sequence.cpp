// A recorded drive in one call: with all its layers, refused, replaced, interrupted and resumed.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/map_sequence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/take_interrupt.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/map_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::FlatDrive;
using test::ScratchFolder;
using Existing = MapSequenceOptions::Existing;

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
  MapSequenceOptions options;
  options.existing = Existing::resume;
  EXPECT_EQ(mapSequence(drive, words, folder / "home.estancia", options).newFrames, drive.size() - 10);
  mapSequence(drive, words, folder / "whole.estancia");
  EXPECT_EQ(readWorld(folder / "home.estancia").areaOfFrame,
            readWorld(folder / "whole.estancia").areaOfFrame);
}

}  // namespace
}  // namespace estancia
