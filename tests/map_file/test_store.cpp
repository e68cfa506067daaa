// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "map_file/small_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using Access = MapStore::Access;
using test::addFrames;
using test::descriptorOf;
using test::FailsWith;
using test::filesIn;
using test::frameNamed;
using test::identity;
using test::smallMap;
using test::tamper;

TEST(MapStore, GivesBackAllThatWasWritten) {
  const test::ScratchFolder folder;
  {
    MapStore store = MapStore::create(folder / "map.estancia", identity());
    MappedFrame posed = frameNamed(0, "a.jpg");
    posed.timestamp = 12.5;
    posed.pose = Pose::planar(1, 2, 0.5);
    posed.room = "kitchen";
    store.addFrame(posed, descriptorOf(0));
    store.addFrame(frameNamed(1, "b.jpg", 4), descriptorOf(1));
    store.putNode({0, 1, {0.5F, 0.25F, 0}, {0.1F, 0, 0}}, std::string("\0state", 6));
    store.putNode({4, 1, {0, 0.25F, 0.75F}, {0, 0.2F, 0}}, "");
    store.putTransition({0, 4, 2, 1});
    store.putDecision({0, DecisionKind::start, 0, -1, std::nan(""), -1, std::nan(""), 0.3, 0.2});
    store.putDecision({1, DecisionKind::createNode, 4, 0, 0.75, 7, 0.5, 0.3, 0.2});
    store.putImage(1, {0xff, 0xd8, 0x00, 0x01});
    store.putState("thresholds", std::string("a\0b", 3));
    store.commit();
  }
  const MapStore store = MapStore::open(folder / "map.estancia", Access::read);
  EXPECT_EQ(store.identity().vocabulary, identity().vocabulary);
  EXPECT_EQ(store.identity().model, "model-1");
  EXPECT_EQ(store.identity().settings, identity().settings);
  const TopologicalMap map = store.load();
  EXPECT_EQ(map.distance, "hellinger");
  ASSERT_EQ(map.frames.size(), 2U);
  EXPECT_EQ(map.frames[0].name, "a.jpg");
  EXPECT_EQ(map.frames[0].timestamp, 12.5);
  ASSERT_TRUE(map.frames[0].pose);
  EXPECT_DOUBLE_EQ(map.frames[0].pose->y, 2);
  EXPECT_DOUBLE_EQ(map.frames[0].pose->qw, Pose::planar(1, 2, 0.5).qw);
  EXPECT_EQ(map.frames[0].room, "kitchen");
  EXPECT_FALSE(map.frames[1].timestamp);
  EXPECT_FALSE(map.frames[1].pose);
  EXPECT_EQ(map.frames[1].node, 4);
  ASSERT_EQ(map.nodes.size(), 2U);
  EXPECT_EQ(map.nodes[1].id, 4);
  EXPECT_EQ(map.nodes[1].mean, (std::vector<float>{0, 0.25F, 0.75F}));
  EXPECT_EQ(map.nodes[1].sigma, (std::vector<float>{0, 0.2F, 0}));
  ASSERT_EQ(map.transitions.size(), 1U);
  EXPECT_EQ(map.transitions[0].to, 4);
  EXPECT_EQ(map.transitions[0].count, 2U);
  EXPECT_EQ(map.transitions[0].firstFrame, 1U);
  ASSERT_EQ(map.decisions.size(), 2U);
  EXPECT_TRUE(std::isnan(map.decisions[0].toCurrent));
  EXPECT_EQ(map.decisions[1].kind, DecisionKind::createNode);
  EXPECT_EQ(map.decisions[1].other, 7);
  EXPECT_DOUBLE_EQ(map.decisions[1].toOther, 0.5);
  EXPECT_EQ(store.nodeStates(),
            (std::vector<std::pair<int, std::string>>{{0, std::string("\0state", 6)}, {4, ""}}));
  EXPECT_EQ(store.findState("thresholds"), std::string("a\0b", 3));
  EXPECT_EQ(store.findState("nothing"), std::nullopt);
  EXPECT_EQ(store.imageFrames(), std::vector<std::size_t>{1});
  EXPECT_EQ(store.image(1), (std::vector<unsigned char>{0xff, 0xd8, 0x00, 0x01}));
  EXPECT_TRUE(store.image(0).empty());
  EXPECT_EQ(store.descriptor(1), descriptorOf(1));
}

TEST(MapStore, TextsOfOthersAreReadWithoutControlCharacters) {
  const test::ScratchFolder folder;
  {
    const Vocabulary labels({"cup\x1B[2J", "red\tdesk", "caf\xE9"}, {{2, 1}, {1, 0.5F}});
    MapStore store =
        MapStore::create(folder / "map.estancia", {labels, "model\x1B]0;x\x07", R"({"distance":"\u001b"})"});
    MappedFrame frame = frameNamed(0, "a\n\xC2\x9B.jpg");
    frame.room = "kitchen\xE2\x80\xAE";
    store.addFrame(frame, descriptorOf(0));
    store.putNode({0, 1, {0.5F, 0.25F, 0}, {0.1F, 0, 0}}, "");
    store.putPredictions({"svm\x1B", {"hall\x1B"}, DescriptorMatrix(1)});
    store.commit();
  }
  const MapStore store = MapStore::open(folder / "map.estancia", Access::read);
  const Vocabulary clean({"cup\\x1B[2J", "red desk", "caf\\xE9"}, {{2, 1}, {1, 0.5F}});
  EXPECT_EQ(store.identity().vocabulary, clean);
  EXPECT_EQ(store.identity().model, "model\\x1B]0;x\\x07");
  const TopologicalMap map = store.load();
  EXPECT_EQ(map.vocabulary, clean);
  EXPECT_EQ(map.model, store.identity().model);
  EXPECT_EQ(map.distance, "\\x1B");
  EXPECT_EQ(map.frames[0].name, "a\\x0A\\xC2\\x9B.jpg");
  EXPECT_EQ(map.frames[0].room, "kitchen\\xE2\\x80\\xAE");
  ASSERT_TRUE(map.predictions);
  EXPECT_EQ(map.predictions->classifier, "svm\\x1B");
  EXPECT_THAT(map.predictions->rooms, testing::ElementsAre("hall\\x1B"));
}

TEST(MapStore, LeavesNothingOnDiskBeforeTheFirstCommit) {
  const test::ScratchFolder folder;
  {
    MapStore store = MapStore::create(folder / "map.estancia", identity());
    addFrames(store, 0, 100);
    EXPECT_TRUE(filesIn(folder.path()).empty());
  }
  EXPECT_TRUE(filesIn(folder.path()).empty());
}

TEST(MapStore, LeavesASingleFileOfWhatWasCommitted) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  {
    std::optional<MapStore> writer(MapStore::open(path, Access::write));
    const MapStore reader = MapStore::open(path, Access::read);
    addFrames(*writer, 3, 10);
    writer->commit();
    addFrames(*writer, 10, 50);
    EXPECT_EQ(writer->frameCount(), 50U);
    writer.reset();
    EXPECT_EQ(reader.load().frames.size(), 10U);
  }
  EXPECT_THAT(filesIn(folder.path()), testing::ElementsAre("map.estancia"))
      << "a reader was the last to close";
}

TEST(MapStore, ShowsReadersTheLastCommitOrOneMomentOverSeveralReads) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  MapStore writer = MapStore::open(path, Access::write);
  MapStore reader = MapStore::open(path, Access::read);
  addFrames(writer, 3, 10);
  EXPECT_EQ(reader.frameCount(), 3U) << "nothing is committed";
  reader.beginReading();
  EXPECT_EQ(reader.frameCount(), 3U);
  writer.putState("memory", "of ten frames");
  writer.commit();
  EXPECT_EQ(reader.load().frames.size(), 3U);
  EXPECT_FALSE(reader.findState("memory"));
  reader.endReading();
  EXPECT_EQ(reader.load().frames.size(), 10U);
  EXPECT_EQ(reader.findState("memory"), "of ten frames");
}

TEST(MapStore, VisitsDescriptorsInOrderAndStopsWhenTold) {
  const test::ScratchFolder folder;
  const MapStore store = MapStore::open(smallMap(folder, 20), Access::read);
  std::vector<std::size_t> visited;
  store.forEachDescriptor(5, [&](std::size_t frame, DescriptorView descriptor) {
    EXPECT_EQ(LexicalDescriptor(descriptor.begin(), descriptor.end()), descriptorOf(frame));
    visited.push_back(frame);
    return frame < 8;
  });
  EXPECT_EQ(visited, (std::vector<std::size_t>{5, 6, 7, 8}));
  EXPECT_THAT([&] { store.descriptor(20); }, FailsWith(ErrorCode::unknownName));
}

TEST(MapStore, VisitsAreRunsOfFramesAtAPlaceWhateverNumbersAreLeftOut) {
  const test::ScratchFolder folder;
  const fs::path file = folder / "map.estancia";
  {
    MapStore store = MapStore::create(file, identity());
    const std::vector<std::pair<std::size_t, int>> nodes = {{0, 0}, {1, 0}, {2, 4}, {3, 4},  {5, 4},
                                                            {6, 0}, {7, 4}, {9, 4}, {10, 0}, {11, 4}};
    for (const auto& [number, node] : nodes)
      store.addFrame(frameNamed(number, "f", node), descriptorOf(number));
    store.putNode({0, 4, {1, 0, 0}, {0, 0, 0}}, "");
    store.putNode({4, 4, {0, 1, 0}, {0, 0, 0}}, "");
    store.commit();
  }
  const auto listed = [](const std::vector<Visit>& visits) {
    std::vector<std::array<int, 3>> rows;
    for (const Visit& visit : visits)
      rows.push_back({visit.node, static_cast<int>(visit.firstFrame), static_cast<int>(visit.lastFrame)});
    return rows;
  };
  EXPECT_THAT(listed(readVisits(file)),
              testing::ElementsAre(std::array{0, 0, 1}, std::array{4, 2, 5}, std::array{0, 6, 6},
                                   std::array{4, 7, 9}, std::array{0, 10, 10}, std::array{4, 11, 11}));
  EXPECT_EQ(listed(readVisits(file)), listed(visitsOf(MapStore::open(file, Access::read).load())));
}

TEST(MapStore, FramesMayBeLeftOut) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  {
    MapStore store = MapStore::open(path, Access::write);
    store.addFrame(frameNamed(5, "f"), descriptorOf(5));
    store.addFrame(frameNamed(4, "e"), descriptorOf(4));  // kept after all
    store.putDecision({4, DecisionKind::join, 0, 0, 0.4, -1, std::nan(""), 0.3, 0.2});
    store.putDecision({5, DecisionKind::join, 0, 0, 0.5, -1, std::nan(""), 0.3, 0.2});
    store.putTransition({0, 0, 1, 3});
    store.putPredictions({"svm", {"hall"}, [] {
                            DescriptorMatrix rows(1);
                            for (int i = 0; i < 5; ++i)
                              rows.append(std::vector<float>{0.1F * static_cast<float>(i)});
                            return rows;
                          }()});
    store.commit();
  }
  const MapStore store = MapStore::open(path, Access::read);
  EXPECT_EQ(store.frameCount(), 6U);
  EXPECT_EQ(store.frameNumbers(), (std::vector<std::size_t>{0, 1, 2, 4, 5}));
  const TopologicalMap map = store.load();
  ASSERT_EQ(map.frames.size(), 5U);
  EXPECT_EQ(map.frames[3].name, "e");
  EXPECT_TRUE(map.isThinned());
  EXPECT_EQ(map.decisions.back().frame, 4U) << "its place in the list";
  EXPECT_EQ(map.decisions.back().toCurrent, 0.5);
  EXPECT_EQ(map.transitions.front().firstFrame, 2U) << "the last one before it that is kept";
  ASSERT_TRUE(map.predictions);
  EXPECT_EQ(map.predictions->probabilities.row(4)[0], 0.4F);
  EXPECT_EQ(store.descriptor(4), descriptorOf(4));
  EXPECT_THAT([&] { store.descriptor(3); }, FailsWith(ErrorCode::unknownName));
  const TopologicalMap half = store.load(3);
  ASSERT_EQ(half.frames.size(), 3U);
  EXPECT_EQ(half.frames[1].number, 2U);
  EXPECT_EQ(half.predictions->probabilities.row(2)[0], 0.4F);
}

TEST(MapStore, RefusesWhatItCannotKeep) {
  const test::ScratchFolder folder;
  MapStore store = MapStore::create(folder / "map.estancia", identity());
  const auto ofAnotherModel = [&] { store.addFrame(frameNamed(0, "a"), LexicalDescriptor{1, 0}); };
  EXPECT_THAT(ofAnotherModel, FailsWith(ErrorCode::mismatch));
  const auto putShortNode = [&] { store.putNode({0, 1, {1, 0}, {0, 0}}, ""); };
  EXPECT_THAT(putShortNode, FailsWith(ErrorCode::mismatch));
  EXPECT_THAT([&] { store.putImage(0, {1}); }, FailsWith(ErrorCode::unknownName));
  constexpr std::size_t maxFrames = std::size_t{1} << 40;
  EXPECT_THAT([&] { store.addFrame(frameNamed(maxFrames, "a"), descriptorOf(0)); },
              FailsWith(ErrorCode::tooLarge));
  EXPECT_NO_THROW(store.addFrame(frameNamed(maxFrames - 1, "a"), descriptorOf(0)));
  EXPECT_THROW(store.addFrame(frameNamed(maxFrames - 1, "a"), descriptorOf(0)), Error) << "twice";

  const test::ScratchFolder other;
  MapStore reader = MapStore::open(smallMap(other), Access::read);
  EXPECT_THAT([&] { reader.putState("a", "b"); }, FailsWith(ErrorCode::invalidState));
  EXPECT_THAT([&] { reader.commit(); }, FailsWith(ErrorCode::invalidState));
}

// ---- files that are not maps

TEST(MapStore, ReadsTheOlderFormatAndUpdatesItWhenItIsWritten) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  const auto version = [&path] {
    return sqlite::Database(path, sqlite::Database::Mode::read).number("PRAGMA user_version");
  };
  tamper(path, "PRAGMA user_version = 4");
  const std::size_t frames = readMap(path).frames.size();
  EXPECT_EQ(version(), 4);
  {
    MapStore store = MapStore::open(path, MapStore::Access::write);
    store.commit();
  }
  EXPECT_EQ(version(), 6);
  EXPECT_EQ(readMap(path).frames.size(), frames);
}

}  // namespace
}  // namespace estancia
