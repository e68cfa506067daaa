// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/sqlite.hpp"
#include "estancia/topology/store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <cmath>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using Access = MapStore::Access;
using test::FailsWith;

MapStore::Identity identity() {
  return {Vocabulary({"cup, mug", "desk", "umbrella"}), "model-1", R"({"distance":"hellinger"})"};
}

LexicalDescriptor descriptorOf(std::size_t frame) {
  return {static_cast<float>(frame % 7) / 7, 0.25F, static_cast<float>(frame % 3) / 4};
}

MappedFrame frameNamed(std::size_t number, const std::string& name, int node = 0) {
  MappedFrame frame;
  frame.number = number;
  frame.name = name;
  frame.node = node;
  return frame;
}

/// Frames first … last − 1, all in node 0.
void addFrames(MapStore& store, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i < last; ++i) {
    store.addFrame(frameNamed(i, "frame " + std::to_string(i)), descriptorOf(i));
    store.putDecision({i, i == 0 ? DecisionKind::start : DecisionKind::join, 0, i == 0 ? -1 : 0, 0.1, -1,
                       std::nan(""), 0.3, 0.2});
  }
  store.putNode({0, last, {0.1F, 0.2F, 0.3F}, {0, 0, 0.05F}}, "memory of node 0");
}

test::Caught refusal(const fs::path& path, Access access = Access::read) {
  return test::caught([&] { MapStore::open(path, access).load(); });
}

std::vector<std::string> filesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  return names;
}

fs::path smallMap(const test::ScratchFolder& folder, std::size_t frames = 3) {
  const fs::path path = folder / "map.estancia";
  MapStore store = MapStore::create(path, identity());
  addFrames(store, 0, frames);
  store.commit();
  return path;
}

/// Changes a map as a hostile or careless program might.
void tamper(const fs::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sql;
  sqlite3_close(database);
}

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

TEST(MapStore, LeavesASingleFileWhenClosed) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  EXPECT_THAT(filesIn(folder.path()), testing::ElementsAre("map.estancia"));
  {
    MapStore store = MapStore::open(path, Access::write);
    addFrames(store, 3, 10);
    store.commit();
  }
  MapStore::open(path, Access::read).load();
  EXPECT_THAT(filesIn(folder.path()), testing::ElementsAre("map.estancia"));
}

TEST(MapStore, LeavesASingleFileWhenAReaderIsTheLastToClose) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  {
    std::optional<MapStore> writer(MapStore::open(path, Access::write));
    const MapStore reader = MapStore::open(path, Access::read);
    addFrames(*writer, 3, 10);
    writer->commit();
    writer.reset();
    EXPECT_EQ(reader.load().frames.size(), 10U);
  }
  EXPECT_THAT(filesIn(folder.path()), testing::ElementsAre("map.estancia"));
}

TEST(MapStore, DropsWhatWasNotCommitted) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  {
    MapStore store = MapStore::open(path, Access::write);
    addFrames(store, 3, 5);
    store.commit();
    addFrames(store, 5, 50);
    EXPECT_EQ(store.frameCount(), 50U);
  }
  EXPECT_EQ(MapStore::open(path, Access::read).load().frames.size(), 5U);
}

TEST(MapStore, ShowsReadersTheLastCommit) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  MapStore writer = MapStore::open(path, Access::write);
  const MapStore reader = MapStore::open(path, Access::read);
  addFrames(writer, 3, 10);
  EXPECT_EQ(reader.load().frames.size(), 3U);
  writer.commit();
  EXPECT_EQ(reader.load().frames.size(), 10U);
  EXPECT_EQ(reader.frameCount(), 10U);
}

TEST(MapStore, AReaderCanHoldOneMomentOverSeveralReads) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  MapStore writer = MapStore::open(path, Access::write);
  MapStore reader = MapStore::open(path, Access::read);
  reader.beginReading();
  EXPECT_EQ(reader.frameCount(), 3U);
  addFrames(writer, 3, 10);
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
  EXPECT_THAT([&] { store.descriptor(20); }, FailsWith(ErrorCode::unknownName, "frame 20", "20 frames"));
}

TEST(MapStore, MovesTheFramesOfAnAbsorbedNode) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  MapStore store = MapStore::open(path, Access::write);
  store.addFrame(frameNamed(3, "d", 1), descriptorOf(3));
  store.putNode({1, 1, {0, 0, 0}, {0, 0, 0}}, "");
  store.putDecision({3, DecisionKind::createNode, 1, 0, 0.5, -1, std::nan(""), 0.3, 0.2});
  store.addMerge({3, 0, 1, 0.1, 0.2});
  const TopologicalMap map = store.load();
  EXPECT_EQ(map.nodes.size(), 1U);
  EXPECT_EQ(map.frames[3].node, 0);
  EXPECT_EQ(map.decisions[3].node, 1) << "what was decided stays as it was";
  ASSERT_EQ(map.merges.size(), 1U);
  EXPECT_EQ(map.merges[0].absorbed, 1);
}

TEST(MapStore, ForgetsTheMapButNotTheFrames) {
  const test::ScratchFolder folder;
  MapStore store = MapStore::open(smallMap(folder), Access::write);
  store.putTransition({0, 0, 1, 1});
  store.clearMap();
  const TopologicalMap map = store.load();
  EXPECT_TRUE(map.nodes.empty());
  EXPECT_TRUE(map.transitions.empty());
  EXPECT_TRUE(map.decisions.empty());
  ASSERT_EQ(map.frames.size(), 3U);
  EXPECT_EQ(map.frames[0].node, -1) << "no node until it is mapped again";
  EXPECT_EQ(store.descriptor(2), descriptorOf(2));
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
  EXPECT_THAT([&] { store.descriptor(3); }, FailsWith(ErrorCode::unknownName, "frame 3", "6 frames"));
  const TopologicalMap half = store.load(3);
  ASSERT_EQ(half.frames.size(), 3U);
  EXPECT_EQ(half.frames[1].number, 2U);
  EXPECT_EQ(half.predictions->probabilities.row(2)[0], 0.4F);
}

TEST(MapStore, RefusesAFrameTwiceAndDescriptorsOfAnotherModel) {
  const test::ScratchFolder folder;
  MapStore store = MapStore::create(folder / "map.estancia", identity());
  const auto ofAnotherModel = [&] { store.addFrame(frameNamed(0, "a"), LexicalDescriptor{1, 0}); };
  EXPECT_THAT(ofAnotherModel, FailsWith(ErrorCode::mismatch, "2 values", "3 labels"));
  const auto putShortNode = [&] { store.putNode({0, 1, {1, 0}, {0, 0}}, ""); };
  EXPECT_THAT(putShortNode, FailsWith(ErrorCode::mismatch, "node 0", "2", "3 labels"));
  EXPECT_THAT([&] { store.putImage(0, {1}); }, FailsWith(ErrorCode::unknownName, "frame 0"));
  store.addFrame(frameNamed(0, "a"), descriptorOf(0));
  EXPECT_THROW(store.addFrame(frameNamed(0, "a"), descriptorOf(0)), Error);
}

TEST(MapStore, RefusesToChangeAMapOpenedForReading) {
  const test::ScratchFolder folder;
  MapStore store = MapStore::open(smallMap(folder), Access::read);
  EXPECT_THAT([&] { store.putState("a", "b"); }, FailsWith(ErrorCode::invalidState));
  EXPECT_THAT([&] { store.commit(); }, FailsWith(ErrorCode::invalidState));
}

// ---- files that are not maps

TEST(MapStoreRefuses, AnExistingPath) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  EXPECT_THAT([&] { MapStore::create(path, identity()); }, FailsWith(ErrorCode::fileExists, path.string()));
  fs::create_symlink(path.filename(), folder / "link.estancia");
  EXPECT_THAT([&] { MapStore::create(folder / "link.estancia", identity()); },
              FailsWith(ErrorCode::fileExists, path.string()));
}

TEST(MapStore, IsMadeWhereALinkLeads) {
  const test::ScratchFolder folder;
  fs::create_symlink("elsewhere.estancia", folder / "link.estancia");
  MapStore::create(folder / "link.estancia", identity()).commit();
  EXPECT_TRUE(fs::is_symlink(folder / "link.estancia"));
  EXPECT_TRUE(fs::is_regular_file(folder / "elsewhere.estancia"));
}

TEST(MapStoreRefuses, APathThatSomebodyElseTookMeanwhile) {
  const test::ScratchFolder folder;
  MapStore store = MapStore::create(folder / "map.estancia", identity());
  test::writeFile(folder / "map.estancia", "precious");
  EXPECT_THAT([&] { store.commit(); }, FailsWith(ErrorCode::fileExists, "map.estancia"));
  EXPECT_EQ(test::readFile(folder / "map.estancia"), "precious");
  EXPECT_THAT(filesIn(folder.path()), testing::ElementsAre("map.estancia"));
  EXPECT_THAT([&] { store.putState("a", "b"); }, FailsWith(ErrorCode::invalidState));
}

TEST(MapStoreRefuses, AMissingFile) {
  const test::ScratchFolder folder;
  EXPECT_THAT(refusal(folder / "no.estancia"), FailsWith(ErrorCode::fileNotFound, "no.estancia"));
  EXPECT_TRUE(filesIn(folder.path()).empty());
}

TEST(MapStoreRefuses, AFolderAndADevice) {
  const test::ScratchFolder folder;
  EXPECT_THAT(refusal(folder.path()), FailsWith(ErrorCode::unsupportedFile, folder.path().string()));
  EXPECT_THAT(refusal("/dev/null"), FailsWith(ErrorCode::unsupportedFile, "/dev/null"));
}

TEST(MapStoreRefuses, ATextFileAndLeavesItAlone) {
  const test::ScratchFolder folder;
  const std::string text(5000, 'x');
  test::writeFile(folder / "text.estancia", text);
  for (const Access access : {Access::read, Access::write})
    EXPECT_THAT(refusal(folder / "text.estancia", access),
                FailsWith(ErrorCode::unsupportedFile, "text.estancia"));
  EXPECT_EQ(test::readFile(folder / "text.estancia"), text);
  test::writeFile(folder / "short.estancia", "hello");
  EXPECT_THAT(refusal(folder / "short.estancia"), FailsWith(ErrorCode::truncatedFile, "5 bytes"));
  test::writeFile(folder / "empty.estancia", "");
  EXPECT_THAT(refusal(folder / "empty.estancia"), FailsWith(ErrorCode::truncatedFile, "0 bytes"));
}

TEST(MapStoreRefuses, AnotherProgramsDatabase) {
  const test::ScratchFolder folder;
  tamper(folder / "other.db", "CREATE TABLE songs(name TEXT)");
  const std::string before = test::readFile(folder / "other.db");
  for (const Access access : {Access::read, Access::write})
    EXPECT_THAT(refusal(folder / "other.db", access), FailsWith(ErrorCode::unsupportedFile, "other.db"));
  EXPECT_EQ(test::readFile(folder / "other.db"), before);
}

TEST(MapStoreRefuses, OtherFormatsNamingBothVersions) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  for (const char* version : {"1", "3", "9"}) {
    tamper(path, std::string("PRAGMA user_version = ") + version);
    EXPECT_THAT(refusal(path),
                FailsWith(ErrorCode::unsupportedFile, std::string("format ") + version, "formats 4 to 6"));
  }
  tamper(path, "PRAGMA user_version = -1");
  EXPECT_THAT(refusal(path), FailsWith(ErrorCode::corruptFile, "-1"));
}

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

TEST(MapStoreRefuses, ATruncatedFileAtEveryLength) {
  const test::ScratchFolder folder;
  const std::string whole = test::readFile(smallMap(folder, 40));
  ASSERT_GT(whole.size(), 8U * 4096);
  for (const std::size_t length :
       {std::size_t{50}, std::size_t{99}, std::size_t{600}, std::size_t{4095}, std::size_t{4096},
        std::size_t{10000}, whole.size() / 2, whole.size() - 4096, whole.size() - 1}) {
    const fs::path path = folder / "cut.estancia";
    test::writeFile(path, whole.substr(0, length));
    const ErrorCode expected = length < 512 ? ErrorCode::truncatedFile : ErrorCode::corruptFile;
    EXPECT_THAT(refusal(path), FailsWith(expected, "cut.estancia")) << length;
    EXPECT_THAT(refusal(path, Access::write), FailsWith(expected, "cut.estancia")) << length;
  }
}

TEST(MapStoreRefuses, AnOverwrittenPage) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder, 40);
  const std::string whole = test::readFile(path);
  // Whatever page is hit, reading ends either well (a free or an index page) or as a damaged file.
  std::size_t refused = 0;
  for (std::size_t page = 1; page < whole.size() / 4096; ++page) {
    std::string damaged = whole;
    for (std::size_t i = 0; i < 4096; ++i) damaged[page * 4096 + i] = static_cast<char>(i * 31 + page);
    test::writeFile(path, damaged);
    const test::Caught caught = test::caught([&] {
      const MapStore store = MapStore::open(path, Access::read);
      store.load();
      store.forEachDescriptor(0, [](std::size_t, DescriptorView) { return true; });
      store.nodeStates();
    });
    if (!caught.code) continue;
    EXPECT_THAT(caught, FailsWith(ErrorCode::corruptFile, path.string())) << page;
    ++refused;
  }
  EXPECT_GE(refused, 6U);
}

TEST(MapStoreRefuses, ContentsThatAreNotToBeBelieved) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"UPDATE nodes SET mean = x'0000'", "2 bytes"},
      {"UPDATE nodes SET sigma = zeroblob(12000000)", "12000000 bytes"},
      {"UPDATE nodes SET mean = x'0000c07f0000c07f0000c07f'", "nan"},
      {"UPDATE nodes SET mean = x'0000a0c00000a0c00000a0c0'", "-5"},
      {"UPDATE nodes SET id = -5", "-5"},
      {"UPDATE nodes SET frames = 0", "image count"},
      {"UPDATE nodes SET id = 1", "node 0"},
      {"UPDATE frames SET node = 99999999999", "99999999999"},
      {"UPDATE frames SET node = -1 WHERE id = 1", "-1"},
      {"DELETE FROM frames WHERE id = 1", "2 of 3 frames"},
      {"UPDATE frames SET id = 9223372036854775807 WHERE id = 2", "frames"},
      {"UPDATE frames SET id = id - 9", "frames"},
      {"INSERT INTO transitions VALUES(0, 7, 1, 1)", "node 7"},
      {"INSERT INTO transitions VALUES(0, 0, 9223372036854775807, 1)", "count is 9223372036854775807"},
      {"UPDATE nodes SET frames = 4", "image count is 4"},
      {"UPDATE decisions SET kind = 5", "decision is 5"},
      {"UPDATE decisions SET frame = 77 WHERE frame = 2", "77"},
      {"UPDATE labels SET label = 'cap' WHERE id = 0", "labels"},
      {"DELETE FROM labels", "labels"},
      {"UPDATE labels SET id = 8 WHERE id = 1", "labels"},
      {"DELETE FROM meta WHERE key = 'model'", "model"},
      {"DROP TABLE merges", "merges"},
      {"DROP TABLE frames; CREATE VIEW frames AS SELECT 1", ""}};
  for (const auto& [sql, expected] : cases) {
    const test::ScratchFolder folder;
    const fs::path path = smallMap(folder);
    tamper(path, sql);
    EXPECT_THAT(refusal(path), FailsWith(ErrorCode::corruptFile, path.string(), expected)) << sql;
  }
}

/// What makes SQLite delete `victim` once it has rolled back by it (file format, 3).
std::string journalNaming(const fs::path& victim, const fs::path& map) {
  constexpr std::size_t sector = 512, page = 4096;
  const auto number = [](std::size_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  const std::string magic = "\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", name = victim.string();
  std::string journal =
      magic + number(0) + number(1) + number(fs::file_size(map) / page) + number(sector) + number(page);
  journal.resize(sector, '\0');
  std::size_t sum = 0;
  for (const char c : name) sum += static_cast<unsigned char>(c);
  return journal + number(0x40000000 / page + 1) + name + number(name.size()) + number(sum) + magic;
}

TEST(MapStoreRefuses, AJournalThatNamesAnotherFile) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder), link = folder / "link.estancia", victim = folder / "precious";
  const fs::path journal = path.string() + "-journal";
  fs::create_symlink(path, link);
  test::writeFile(victim, "precious");
  test::writeFile(journal, journalNaming(victim, path));
  for (const fs::path& name : {path, link}) {
    EXPECT_THAT(refusal(name), FailsWith(ErrorCode::corruptFile, journal.string(), "names another file"));
    EXPECT_TRUE(fs::exists(victim));
  }
  sqlite3* database = nullptr;  // that it is such a journal
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "SELECT * FROM frames", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_FALSE(fs::exists(victim));
  EXPECT_EQ(MapStore::open(path, Access::read).frameCount(), 3U);
}

TEST(MapStoreRefuses, PipesAndFoldersBesideIt) {
  for (const char* suffix : {"-journal", "-wal", "-shm"}) {
    const test::ScratchFolder folder;
    const fs::path path = smallMap(folder), beside = path.string() + suffix;
    ASSERT_EQ(mkfifo(beside.c_str(), 0600), 0);
    EXPECT_THAT(refusal(path), FailsWith(ErrorCode::unsupportedFile, beside.string(), "no regular file"));
  }
}

TEST(MapStoreRefuses, SchemasThatCalculate) {
  for (const std::string& sql : {std::string("CREATE TABLE other(a, b AS (zeroblob(9)))"),
                                 std::string("CREATE TABLE other(a, b TEXT DEFAULT (hex(zeroblob(9))))"),
                                 std::string("CREATE INDEX other ON frames(hex(name))"),
                                 std::string("CREATE INDEX other ON frames(node) WHERE hex(name) = '00'"),
                                 std::string("CREATE VIRTUAL TABLE other USING fts5(a)")}) {
    const test::ScratchFolder folder;
    const fs::path path = smallMap(folder);
    tamper(path, sql);
    EXPECT_THAT(refusal(path), FailsWith(ErrorCode::corruptFile, "schema", "other")) << sql;
  }
}

TEST(MapStore, RunsNoConstraintsOfTheFile) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  tamper(path,
         "CREATE TABLE other(key TEXT PRIMARY KEY, bytes BLOB NOT NULL, CHECK(length(bytes) < 0)); "
         "DROP TABLE state; ALTER TABLE other RENAME TO state");
  MapStore store = MapStore::open(path, Access::write);
  EXPECT_NO_THROW(store.putState("key", "bytes"));
}

TEST(MapStore, TakesBackWhatRoundingLeftBeyondProbabilities) {
  const test::ScratchFolder folder;
  const fs::path path = folder / "map.estancia";
  const LexicalDescriptor rounded{-5e-5F, 1.00005F, 0};  // requireProbabilities() lets it in
  {
    MapStore store = MapStore::create(path, identity());
    store.addFrame(frameNamed(0, "a"), rounded);
    store.putNode({0, 1, rounded, {0, 0, 0}}, "");
    store.commit();
  }
  const MapStore store = MapStore::open(path, Access::read);
  EXPECT_EQ(store.descriptor(0), rounded);
  EXPECT_EQ(store.load().nodes.front().mean, rounded);
}

TEST(MapStoreRefuses, DescriptorsOfAWrongLength) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  tamper(path, "UPDATE descriptors SET probabilities = x'00' WHERE frame = 1");
  const MapStore store = MapStore::open(path, Access::read);
  EXPECT_THAT([&] { store.descriptor(1); }, FailsWith(ErrorCode::corruptFile, "frame 1", "1 bytes"));
  EXPECT_THAT([&] { store.forEachDescriptor(0, [](std::size_t, DescriptorView) { return true; }); },
              FailsWith(ErrorCode::corruptFile, "1 bytes"));
}

}  // namespace
}  // namespace estancia
