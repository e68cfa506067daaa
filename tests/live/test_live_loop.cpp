// The live loop: maps that grow, edits on the way, and whatever goes wrong with a robot.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/live_loop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "estancia/labelers/recorded_labeler.hpp"
#include "estancia/live/map_file_view.hpp"
#include "estancia/sources/replay_source.hpp"
#include "support/errors.hpp"
#include "support/fed_source.hpp"
#include "support/flat_drive.hpp"
#include "support/map_drive.hpp"
#include "support/shape_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::FailsWith;
using test::FedSource;
using test::FlatDrive;
using test::ScratchFolder;

/// A drive without odometry.
class ImagesAlone : public FlatDrive {
 public:
  ImagesAlone() {
    for (Frame& frame : frames_) frame.pose.reset();
  }
  bool hasDepth() const override { return false; }
};

/// The drive's own words.
RecordedLabeler labelerOf(const FlatDrive& drive) {
  return RecordedLabeler(drive.labeled());
}

std::unique_ptr<ReplaySource> replay() {
  return std::make_unique<ReplaySource>(std::make_unique<FlatDrive>(), ReplayOptions{.rate = 0});
}

/// A loop in a thread of its own, over frames that a test feeds.
class FedLoop {
 public:
  FedLoop(const fs::path& map, Labeler& labeler, const Sequence& like, const LiveOptions& options = {}) {
    auto source = std::make_unique<FedSource>(like);
    source_ = source.get();
    loop_ = std::make_unique<LiveLoop>(std::move(source), labeler, map, options);
    thread_ = std::thread([this] {
      try {
        loop_->run();
      } catch (const std::exception& e) {
        failure_ = e.what();
      }
    });
  }
  ~FedLoop() { end(); }
  FedLoop(const FedLoop&) = delete;
  FedLoop& operator=(const FedLoop&) = delete;

  FedSource& source() { return *source_; }
  LiveLoop& loop() { return *loop_; }
  /// Why it ended, if that was a failure.
  std::string end() {
    source_->end();
    if (thread_.joinable()) thread_.join();
    return failure_;
  }
  /// Until that is so; false after two minutes: sanitizers derive a map in seconds, and then pause for fifty
  /// times as long as that held up the loop.
  bool waitUntil(const std::function<bool(const LiveStatus&)>& isSo) {
    for (int i = 0; i < 1200; ++i) {
      const LiveStatus now = loop_->status();
      if (isSo(now)) return true;
      loop_->waitForChange(now.revision, 100ms);
    }
    return false;
  }

 private:
  FedSource* source_ = nullptr;
  std::unique_ptr<LiveLoop> loop_;
  std::thread thread_;
  std::string failure_;
};

TEST(LiveLoop, MapsADriveAsItComes) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  LiveLoop live(replay(), labeler, file);
  EXPECT_EQ(live.world(), nullptr);
  std::vector<std::string> names;
  live.run([&](const LiveStatus& now) {
    names.push_back(now.frame);
    EXPECT_EQ(now.state, "mapping");
    ASSERT_EQ(now.places.size(), 1U);
    EXPECT_TRUE(now.pose);
    EXPECT_FALSE(now.words.empty());
  });
  EXPECT_EQ(names.size(), drive.size());
  const LiveStatus last = live.status();
  EXPECT_EQ(last.state, "ended");
  EXPECT_EQ(last.frames, drive.size());
  EXPECT_EQ(last.dropped + last.failed, 0U);
  EXPECT_GE(last.mapRevision, 1U);
  EXPECT_THAT(last.troubles, testing::IsEmpty());
  const auto world = live.world();
  ASSERT_NE(world, nullptr);
  EXPECT_EQ(world->areas.size(), 3U);
  EXPECT_EQ(world->places.frames.size(), drive.size());
  EXPECT_EQ(readWorld(file).areaOfFrame, world->areaOfFrame);
  ASSERT_NE(live.image(), nullptr);
  EXPECT_FALSE(live.image()->empty());
  EXPECT_FALSE(live.placeImage(world->places.nodes.front().id).empty());
  EXPECT_TRUE(live.placeImage(12345).empty());
  EXPECT_EQ(MapFileView(file).placeImage(world->places.nodes.front().id),
            live.placeImage(world->places.nodes.front().id));
  EXPECT_THAT([&] { live.run(); }, FailsWith(ErrorCode::invalidState));
}

TEST(LiveLoop, MakesTheVeryMapOfFramesThatAreMappedInOrder) {
  const ScratchFolder folder;
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  LiveLoop(replay(), labeler, folder / "live.estancia").run();
  test::mapUpTo(drive, drive.labeled(), drive.size(), folder / "plain.estancia");
  const WorldMap live = readWorld(folder / "live.estancia"), plain = readWorld(folder / "plain.estancia");
  EXPECT_EQ(live.areaOfFrame, plain.areaOfFrame);
  EXPECT_EQ(live.zoneOfFrame, plain.zoneOfFrame);
  ASSERT_EQ(live.places.frames.size(), plain.places.frames.size());
  for (std::size_t i = 0; i < plain.places.frames.size(); ++i)
    EXPECT_EQ(live.places.frames[i].node, plain.places.frames[i].node) << i;
}

TEST(LiveLoop, StopsWhenItIsToldAndGoesOnLater) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  {
    LiveLoop live(replay(), labeler, file);
    live.run([&](const LiveStatus& now) {
      if (now.frames == 20) live.stop();
    });
    EXPECT_EQ(live.status().frames, 20U);
  }
  EXPECT_EQ(readMap(file).frames.size(), 20U);
  LiveLoop later(replay(), labeler, file);
  ASSERT_NE(later.world(), nullptr) << "it is there before the first frame";
  later.run();
  EXPECT_EQ(later.status().frames, drive.size() - 20);
  EXPECT_EQ(readMap(file).frames.size(), drive.size());
  EXPECT_EQ(readWorld(file).areas.size(), 3U);
}

TEST(LiveLoop, EditsTheMapWhileItGrows) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  FedLoop fed(file, labeler, drive);
  for (std::size_t i = 0; i < drive.size(); ++i) fed.source().feed(drive, i);
  const auto hasRooms = [&](const LiveStatus& now) {
    const auto world = fed.loop().world();  // areas of some frames come first
    return now.frames == drive.size() && world && world->areas.size() == 3 &&
           world->areaOfFrame.size() == drive.size() && std::ranges::count(world->areaOfFrame, -1) == 0;
  };
  ASSERT_TRUE(fed.waitUntil(hasRooms));
  LiveLoop& live = fed.loop();
  const int bedroom = live.world()->areaOfFrame[0], corridor = live.world()->areaOfFrame[20];
  const std::uint64_t before = live.status().mapRevision;
  live.edit(NameArea{bedroom, "Ana's room"});
  EXPECT_EQ(live.world()->findArea(bedroom)->displayName(), "Ana's room");
  EXPECT_GT(live.status().mapRevision, before);
  EXPECT_THAT([&] { live.edit(NameArea{77, "hall"}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { live.edit(NameArea{bedroom, "7"}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { live.edit(MergeAreas{bedroom, bedroom}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { live.edit(NameObject{0, "cup"}); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { live.edit(SplitArea{{500, 500}, {501, 500}}); }, FailsWith(ErrorCode::invalidInput));
  live.edit(MergeAreas{bedroom, corridor});
  EXPECT_EQ(live.world()->areas.size(), 2U);
  live.edit(SplitArea{{2, 0.2}, {2, 3.8}});
  EXPECT_EQ(live.world()->areas.size(), 3U);
  LiveFrame more;
  more.frame = drive.frame(0);
  more.frame.name = "frame 0";
  more.image = drive.image(0);
  more.depth = drive.depth(0);
  fed.source().feed(more);  // refused edits have cost the map nothing
  EXPECT_EQ(fed.end(), "");
  EXPECT_EQ(live.status().failed, 0U);
  const WorldMap kept = readWorld(file);
  EXPECT_EQ(kept.places.frames.size(), drive.size() + 1);
  EXPECT_EQ(kept.areas.size(), 3U);
  EXPECT_EQ(kept.findArea(kept.areaOfFrame[0])->displayName(), "Ana's room");
  live.edit(NameArea{kept.areaOfFrame[0], "den"});  // at rest, too
  EXPECT_EQ(readWorld(file).findArea(kept.areaOfFrame[0])->displayName(), "den");
}

/// Feeds frames of the drive, and waits until all are mapped.
void feedAndWait(FedLoop& fed, const Sequence& drive, std::size_t from, std::size_t to) {
  const std::size_t before = fed.loop().status().frames;
  for (std::size_t i = from; i < to; ++i) fed.source().feed(drive, i);
  ASSERT_TRUE(fed.waitUntil([&](const LiveStatus& now) { return now.frames == before + to - from; }));
}

TEST(LiveLoop, ObjectsKeepTheirNamesAndStayAwayWhenDeletedToTheEndAndAfterIt) {
  const ScratchFolder folder;
  const fs::path file = folder / "desk.estancia";
  const test::ShapeDrive drive(test::desk);
  RecordedLabeler labeler = labelerOf(drive);
  const std::string name = "Ana's \"desk\"";
  {
    FedLoop fed(file, labeler, drive);
    LiveLoop& live = fed.loop();
    feedAndWait(fed, drive, 0, 6);
    ASSERT_TRUE(fed.waitUntil([&](auto&) { return live.world() && live.world()->objects.size() == 1; }));
    const std::uint64_t before = live.status().mapRevision;
    live.edit(NameObject{0, name});
    EXPECT_EQ(live.world()->objects.at(0).displayName(), name) << "at once";
    EXPECT_GT(live.status().mapRevision, before);
    EXPECT_THAT([&] { live.edit(NameObject{0, "12"}); }, FailsWith(ErrorCode::invalidInput));
    EXPECT_THAT([&] { live.edit(DeleteObject{7}); }, FailsWith(ErrorCode::unknownName));
    feedAndWait(fed, drive, 6, 9);
    EXPECT_EQ(fed.end(), "");
    EXPECT_EQ(live.status().failed, 0U);
  }
  ASSERT_EQ(readWorld(file).objects.size(), 1U);
  EXPECT_EQ(readWorld(file).objects[0].givenName, name);
  LiveOptions localized;
  localized.posesAreInMap = true;
  FedLoop later(file, labeler, drive, localized);
  ASSERT_NE(later.loop().world(), nullptr);
  EXPECT_EQ(later.loop().world()->objects.at(0).givenName, name) << "before its first frame";
  feedAndWait(later, drive, 9, 11);
  later.loop().edit(DeleteObject{0});
  EXPECT_TRUE(later.loop().world()->objects.empty()) << "at once";
  EXPECT_THAT([&] { later.loop().edit(DeleteObject{0}); }, FailsWith(ErrorCode::insufficientData));
  feedAndWait(later, drive, 11, drive.size());  // they show it again
  EXPECT_EQ(later.end(), "");
  EXPECT_TRUE(later.loop().world()->objects.empty());
  EXPECT_TRUE(readWorld(file).objects.empty());
  EXPECT_EQ(readWorld(file).places.frames.size(), drive.size());
}

TEST(LiveLoop, CallsAreasByRoomsWhileTheMapGrowsAndInTheEnd) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler(drive.labeledInWords());
  FedLoop fed(file, labeler, drive);
  for (std::size_t i = 0; i < drive.size(); ++i) fed.source().feed(drive, i);
  const auto hasBedroom = [&](const LiveStatus&) {
    const auto world = fed.loop().world();
    return world && std::ranges::count(world->areas, "bedroom", &WorldArea::roomName) == 1;
  };
  EXPECT_TRUE(fed.waitUntil(hasBedroom));
  EXPECT_FALSE(readMap(file).predictions) << "the file is the mapper's";
  EXPECT_EQ(fed.end(), "");
  EXPECT_TRUE(hasBedroom(fed.loop().status()));
  EXPECT_TRUE(readMap(file).predictions);
}

TEST(LiveLoop, FindsFramesInAMapThatIsThere) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  LiveLoop(replay(), labeler, file).run();
  const WorldMap map = readWorld(file);
  LiveOptions options;
  options.localize = true;
  auto source = std::make_unique<ReplaySource>(std::make_unique<ImagesAlone>(), ReplayOptions{.rate = 0});
  LiveLoop live(std::move(source), labeler, file, options);
  std::size_t frame = 0, right = 0;
  live.run([&](const LiveStatus& now) {
    EXPECT_EQ(now.state, "localizing");
    ASSERT_FALSE(now.places.empty());
    EXPECT_GT(now.places.front().probability, 0);
    right += now.area == map.areaOfFrame[frame++] ? 1 : 0;
  });
  EXPECT_GT(right, drive.size() / 3);
  EXPECT_EQ(readMap(file).frames.size(), drive.size()) << "nothing is added";
  EXPECT_THAT([&] { LiveLoop(replay(), labeler, folder / "none.estancia", options); },
              FailsWith(ErrorCode::fileNotFound));
}

TEST(LiveLoop, RefusesAMapOfAnotherModel) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  LiveLoop(replay(), labeler, file).run();
  DescriptorSequence other = drive.labeled();
  other.model = "another";
  RecordedLabeler another(other);
  LiveOptions options;
  for (const bool localize : {false, true}) {
    options.localize = localize;
    EXPECT_THAT([&] { LiveLoop(replay(), another, file, options); }, FailsWith(ErrorCode::mismatch));
  }
}

TEST(LiveLoop, AFrameThatCannotBeLabeledCostsOnlyItself) {
  const ScratchFolder folder;
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  FedLoop fed(folder / "flat.estancia", labeler, drive);
  EXPECT_TRUE(fed.loop().objectImage(0).empty()) << "there is no map yet";
  EXPECT_TRUE(fed.loop().placeImage(0).empty());
  EXPECT_THAT([&] { fed.loop().changes({}); }, FailsWith(ErrorCode::insufficientData));
  fed.source().feed(drive, 0);
  LiveFrame unknown;
  unknown.frame.name = "a frame without words";
  unknown.image = drive.image(0);
  fed.source().feed(unknown);
  ASSERT_TRUE(fed.waitUntil([](const LiveStatus& now) { return now.failed == 1; }));
  EXPECT_THAT(fed.loop().status().troubles, testing::SizeIs(1));
  fed.source().feed(drive, 1);
  ASSERT_TRUE(fed.waitUntil([](const LiveStatus& now) { return now.frames == 2; }));
  EXPECT_THAT(fed.loop().status().troubles, testing::IsEmpty());
  EXPECT_EQ(fed.end(), "");
}

/// Files of this process may not grow beyond `bytes` meanwhile.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

TEST(LiveLoop, WaitsForRoomOnAFullDiskAndMapsOn) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  FedLoop fed(file, labeler, drive);
  for (std::size_t i = 0; i < 30; ++i) fed.source().feed(drive, i);
  ASSERT_TRUE(fed.waitUntil([&](const LiveStatus& now) {  // what is not written yet is lost on a full disk
    return now.frames == 30 && fs::exists(file) && readWorld(file).places.frames.size() > 20;
  }));
  std::size_t next = 30;
  const auto feedUntil = [&](const std::function<bool(const LiveStatus&)>& isSo) {
    for (int i = 0; i < 600 && !isSo(fed.loop().status()); ++i) {
      LiveFrame live;
      live.frame = drive.frame(next % drive.size());
      live.image = drive.image(0);
      live.depth = drive.depth(next++ % drive.size());
      fed.source().feed(live);
      std::this_thread::sleep_for(50ms);
    }
    return isSo(fed.loop().status());
  };
  {
    const FullDisk full(4096);
    EXPECT_TRUE(feedUntil([](const LiveStatus& now) { return !now.troubles.empty(); }));
  }
  const std::size_t before = fed.loop().status().frames;
  EXPECT_TRUE(feedUntil([&](const LiveStatus& now) { return now.frames > before && now.troubles.empty(); }));
  EXPECT_EQ(fed.end(), "");
  const WorldMap kept = readWorld(file);
  EXPECT_GT(kept.places.frames.size(), 20U);
  EXPECT_FALSE(kept.areas.empty());
}

TEST(LiveLoop, EndsWhenTheMapIsTakenAway) {
  const ScratchFolder folder;
  const fs::path file = folder / "flat.estancia";
  const FlatDrive drive;
  RecordedLabeler labeler = labelerOf(drive);
  FedLoop fed(file, labeler, drive);
  for (std::size_t i = 0; i < 30; ++i) fed.source().feed(drive, i);
  ASSERT_TRUE(fed.waitUntil([&](const LiveStatus& now) { return now.frames == 30 && fs::exists(file); }));
  fs::remove(file);
  for (std::size_t i = 30; i < drive.size(); ++i) fed.source().feed(drive, i);
  EXPECT_NE(fed.end(), "");
  EXPECT_EQ(fed.loop().status().state, "ended");
  EXPECT_FALSE(fs::exists(file)) << "no other map is begun";
}

}  // namespace
}  // namespace estancia
