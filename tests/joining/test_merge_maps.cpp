// Maps made anew of the drives of others: merged, and without a drive.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/output_file.hpp"
#include "estancia/joining/merge_maps.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "estancia/core/pose.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/query/drives.hpp"
#include "estancia/query/explain.hpp"
#include "estancia/session/session.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_file/world_map.hpp"
#include "estancia/world_file/world_options.hpp"
#include "estancia/world_file/world_store.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::ScratchFolder;

const cv::Affine3d otherFrame(cv::Vec3d(0, 0, 2.1), cv::Vec3d(7, -3, 0));

Vocabulary words(int count = 60) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back("word " + std::to_string(i));
  return Vocabulary(names);
}

/// Circles through twelve places, and through twelve others.
class MergedDrives : public testing::Test {
 protected:
  static Pose poseAt(std::size_t step) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(step) / 48;
    return Pose::planar(4 * std::cos(angle), 4 * std::sin(angle), angle + std::numbers::pi / 2);
  }

  void drive(const std::string& map, std::size_t begin, std::size_t end, std::size_t firstPlace = 0,
             const cv::Affine3d& frame = cv::Affine3d::Identity()) {
    std::vector<std::size_t> seen;
    for (std::size_t i = begin; i < end; ++i) seen.push_back(firstPlace + i / 4 % 12);
    drive(map, begin, seen, frame);
  }
  /// What is seen at each step.
  void drive(const std::string& map, std::size_t begin, const std::vector<std::size_t>& seen,
             const cv::Affine3d& frame) {
    const fs::path file = folder_ / map;
    MappingSession session = fs::exists(file) ? MappingSession::resume(file, words(), "test")
                                              : MappingSession::create(file, words(), "test", options_);
    session.beginDrive({map + " " + std::to_string(begin)});
    for (std::size_t i = begin; i < begin + seen.size(); ++i) {
      Frame known;
      known.name = map + std::to_string(i);
      if (hasPoses_) known.pose = poseOf(frame.inv() * rigidOf(poseAt(i)));
      session.add(known, places_.image(seen[i - begin]), [] { return std::vector<unsigned char>{1, 2}; });
    }
    session.finish();
  }
  TopologicalMap read(const std::string& map) const { return readMap(folder_ / map); }
  MergedMaps merge(const std::vector<std::string>& maps, const std::string& output) const {
    std::vector<fs::path> files;
    for (const std::string& map : maps) files.push_back(folder_ / map);
    return mergeMaps(files, folder_ / output);
  }
  bool isAlone(const std::string& map) const {
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      if (entry.path().filename().string().find("." + map + ".") == 0) return false;
    return true;
  }

  ScratchFolder folder_;
  bool hasPoses_ = true;
  MapperOptions options_;
  test::SyntheticPlaces places_{24, 60, 0.6};
};

void expectSame(const TopologicalMap& a, const TopologicalMap& b) {
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].node, b.frames[i].node) << i;
    EXPECT_EQ(a.frames[i].name, b.frames[i].name) << i;
    EXPECT_EQ(a.frames[i].pose.has_value(), b.frames[i].pose.has_value()) << i;
  }
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) EXPECT_EQ(a.nodes[i].mean, b.nodes[i].mean) << i;
  EXPECT_EQ(a.transitions.size(), b.transitions.size());
}

TEST_F(MergedDrives, AreOneMap) {
  drive("a", 0, 120);
  drive("b", 10, 90, 0, otherFrame);
  drive("c", 0, 60, 12, otherFrame);
  const MergedMaps merged = merge({"a", "b", "c"}, "all");
  EXPECT_EQ(merged.drives, 3U);
  EXPECT_EQ(merged.frames, 260U);
  ASSERT_EQ(merged.parts.size(), 2U);
  EXPECT_TRUE(merged.parts[0].isRecognized && merged.parts[0].isAligned);
  EXPECT_FALSE(merged.parts[1].isRecognized || merged.parts[1].isAligned) << "another house";
  EXPECT_TRUE(isAlone("all"));
  const TopologicalMap all = read("all");
  ASSERT_EQ(all.drives.size(), 3U);
  EXPECT_EQ(all.drives[1].name, "b 10");
  for (std::size_t i = 120; i < 200; ++i)
    EXPECT_LT(distanceBetween(all.frames[i].pose.value(), poseAt(i - 110)), 0.5) << i;
  for (std::size_t i = 200; i < 260; ++i) EXPECT_FALSE(all.frames[i].pose);
  EXPECT_EQ(merged.places, all.nodes.size());
  drive("all", 20, 80, 0, otherFrame);
  const TopologicalMap further = read("all");
  EXPECT_EQ(further.nodes.size(), merged.places) << "it goes on, and all is recognized";
  for (std::size_t i = 260; i < 320; ++i)
    EXPECT_LT(distanceBetween(further.frames[i].pose.value(), poseAt(i - 240)), 0.5) << i;
}

std::vector<std::string> namesOf(const std::vector<Drive>& drives) {
  std::vector<std::string> names;
  for (const Drive& drive : drives) names.push_back(drive.name);
  return names;
}

TEST_F(MergedDrives, KeepTheEndsOfPlacesByTheirOwnImages) {
  options_.transitionImages = 3;
  drive("a", 0, 120);
  drive("c", 0, 60, 12, otherFrame);
  merge({"a", "c"}, "all");
  const MapStore store = MapStore::open(folder_ / "all", MapStore::Access::read);
  const Mapper mapper = restoreMapper(store);
  const TopologicalMap map = read("all");
  std::size_t images = 0;
  for (std::size_t slot = 0; slot < mapper.impl().bank.size(); ++slot)
    for (const NodeBorder::Image& image : mapper.impl().bank[slot].border.images) {
      EXPECT_EQ(map.frames.at(image.frame).node, mapper.impl().bank[slot].id);
      images += image.frame >= 120 ? 1 : 0;
    }
  EXPECT_GT(images, 0U) << "of the second drive, too";
}

TEST_F(MergedDrives, WaitForAMapThatTheyShareAPlaceWith) {
  hasPoses_ = false;
  drive("a", 0, 60);
  drive("c", 0, 60, 12);
  drive("b", 0, 48, 6);  // half of a's places and half of c's
  const MergedMaps merged = merge({"a", "c", "b"}, "all");
  EXPECT_TRUE(merged.parts[0].isRecognized && merged.parts[1].isRecognized);
  EXPECT_FALSE(merged.parts[0].hasPoses);
  const TopologicalMap all = read("all");
  EXPECT_THAT(namesOf(all.drives), testing::ElementsAre("a 0", "b 0", "c 0"));
  EXPECT_EQ(merged.places, 24U);
  for (std::size_t i = 0; i < 24; ++i) {  // b's first six places, and its others
    EXPECT_EQ(all.frames[60 + i].node, all.frames[24 + i].node) << i;
    EXPECT_EQ(all.frames[84 + i].node, all.frames[108 + i].node) << i;
  }
  std::uint64_t held = 0, driven = 0;
  for (const Node& node : all.nodes) held += node.frames;
  for (const Transition& transition : all.transitions) driven += transition.count;
  EXPECT_EQ(held, all.frames.size());
  EXPECT_EQ(driven, 14U + 11U + 14U);
}

TEST_F(MergedDrives, AreNotOnePlaceWherePosesContradict) {
  drive("a", 0, 120);
  std::vector<std::size_t> seen;  // the sixth place on the other side of the circle
  for (std::size_t i = 0; i < 48; ++i) seen.push_back(i >= 40 ? 5 : i / 4 == 5 ? 15 : i / 4);
  drive("b", 0, seen, otherFrame);
  merge({"a", "b"}, "all");
  const TopologicalMap all = read("all");
  ASSERT_TRUE(all.drives[1].alignment);
  EXPECT_EQ(all.frames[120 + 16].node, all.frames[16].node);
  EXPECT_NE(all.frames[120 + 44].node, all.frames[20].node);
  hasPoses_ = false;
  drive("c", 0, seen, otherFrame);
  merge({"a", "c"}, "without poses");
  const TopologicalMap other = read("without poses");
  EXPECT_EQ(other.frames[120 + 44].node, other.frames[20].node) << "words alone would join them";
  drive("d", 0, 48);
  merge({"a", "d", "b"}, "third");
  const TopologicalMap third = read("third");
  ASSERT_EQ(third.drives[2].name, "b 0");
  EXPECT_EQ(third.frames[168 + 16].node, third.frames[16].node);
  EXPECT_NE(third.frames[168 + 44].node, third.frames[20].node) << "not through a map without poses either";
}

TEST_F(MergedDrives, MayTakeWhatTheirMapsMayTogether) {
  hasPoses_ = false;
  for (const std::string map : {"a", "b"}) {
    drive(map, map == "a" ? 0 : 7, 300);
    MappingSession session = MappingSession::resume(folder_ / map, words(), "test");
    session.setBudget({.memory = 2, .file = 2});
    session.finish();
  }
  merge({"a", "b"}, "all");
  drive("c", 0, 60);
  merge({"all", "c"}, "more");
  {
    const MappingSession all = MappingSession::resume(folder_ / "all", words(), "test");
    EXPECT_EQ(all.budget(), (MapBudget{.memory = 4, .file = 4}));
  }
  EXPECT_EQ(MappingSession::resume(folder_ / "more", words(), "test").budget(), MapBudget{});
  EXPECT_EQ(read("all").nodes.size(), 12U);
}

/// Thirteen robots: blocks of pairs of maps, done in any order, by any number of processes.
TEST_F(MergedDrives, AreTheSameHoweverTheWorkIsShared) {
  hasPoses_ = false;
  std::vector<std::string> maps;
  std::vector<fs::path> files;
  for (std::size_t robot = 0; robot < 13; ++robot) {
    maps.push_back("robot " + std::to_string(robot));
    files.push_back(folder_ / maps.back());
    drive(maps.back(), 0, 40, robot % 3 * 6);
  }
  merge(maps, "all");
  ShareWork helping{.leads = false};
  std::vector<std::string> results;
  helping.run = [&](std::size_t pieces, const std::function<std::string(std::size_t)>& work) {
    results.resize(pieces);
    for (std::size_t piece = pieces; piece-- > 0;) results[piece] = work(piece);
    return std::vector<std::string>();
  };
  EXPECT_EQ(mergeMaps(files, folder_ / "shared", ExistingMap::refuse, Progress::none(), helping).drives, 0U);
  EXPECT_FALSE(fs::exists(folder_ / "shared")) << "the other one makes it";
  ShareWork leading;
  leading.run = [&](std::size_t pieces, const std::function<std::string(std::size_t)>&) {
    EXPECT_EQ(pieces, results.size());
    EXPECT_GT(pieces, 3U);
    return results;
  };
  mergeMaps(files, folder_ / "shared", ExistingMap::refuse, Progress::none(), leading);
  expectSame(read("shared"), read("all"));
  EXPECT_EQ(read("all").nodes.size(), 22U) << "places 0 to 21";
}

TEST_F(MergedDrives, CanBeUndone) {
  drive("one", 0, 120);
  const TopologicalMap before = read("one");
  drive("one", 10, 90, 0, otherFrame);
  ASSERT_EQ(read("one").drives.size(), 2U);
  undoDrive(folder_ / "one", 1);
  expectSame(read("one"), before);
  EXPECT_TRUE(isAlone("one"));
  drive("one", 20, 80);
  undoDrive(folder_ / "one", 0);
  const TopologicalMap rest = read("one");
  EXPECT_EQ(rest.frames.size(), 60U);
  EXPECT_EQ(rest.frames.front().name, "one20");
  drive("one", 30, 90);
  EXPECT_EQ(read("one").drives.size(), 2U) << "and it goes on";
}

TEST_F(MergedDrives, KeepThePosesThatTheyWereGivenAndWhereTheyAre) {
  drive("a", 0, 120);
  drive("b", 10, 90, 0, otherFrame);
  drive("b", 20, 80);  // in a third frame, aligned in b
  ASSERT_TRUE(read("b").drives[1].alignment);
  merge({"a", "b"}, "all");
  const auto expectAt = [](const TopologicalMap& map, std::size_t first, std::size_t step) {
    for (std::size_t i = first; i < first + 40; ++i)
      EXPECT_LT(distanceBetween(map.frames[i].pose.value(), poseAt(i - first + step)), 0.6) << i;
  };
  const TopologicalMap all = read("all");
  ASSERT_EQ(all.drives.size(), 3U);
  expectAt(all, 120, 10);
  expectAt(all, 200, 20);
  EXPECT_TRUE(all.drives[2].alignment) << "own poses, with which the drive can be gone on";
  undoDrive(folder_ / "all", 1);
  const TopologicalMap rest = read("all");
  ASSERT_TRUE(rest.drives[1].alignment);
  EXPECT_EQ(rest.drives[1].alignment->x, all.drives[2].alignment->x);
  expectAt(rest, 120, 20);
}

TEST_F(MergedDrives, AreRefusedWhereTheyDoNotFitOrAreDamaged) {
  for (const std::string map : {"a", "b", "damaged", "stateless"}) drive(map, map == "a" ? 0 : 10, 60);
  const auto damage = [&](const std::string& map, const std::string& statement) {
    sqlite::Database(folder_ / map, sqlite::Database::Mode::write).run(statement);
  };
  damage("damaged", "DELETE FROM nodes");
  damage("stateless", "DELETE FROM state WHERE key = 'mapper'");
  {
    Frame named;
    named.name = "x";
    MappingSession other = MappingSession::create(folder_ / "other", words(12), "test", {});
    other.add(named, std::vector<float>(12, 0.1F));
    MappingSession model = MappingSession::create(folder_ / "model", words(), "another", {});
    model.add(named, places_.image(0));
    MapperOptions hellinger;
    hellinger.distance = "hellinger";
    MappingSession distance = MappingSession::create(folder_ / "distance", words(), "test", hellinger);
    distance.add(named, places_.image(0));
  }
  const std::pair<std::vector<std::string>, ErrorCode> cases[] = {
      {{"a"}, ErrorCode::invalidInput},
      {{"a", "a"}, ErrorCode::invalidInput},
      {{"a", "missing"}, ErrorCode::fileNotFound},
      {{"a", "damaged"}, ErrorCode::corruptFile},
      {{"a", "stateless"}, ErrorCode::corruptFile},
      {{"a", "other"}, ErrorCode::mismatch},
      {{"a", "model"}, ErrorCode::mismatch},
      {{"a", "distance"}, ErrorCode::mismatch}};
  for (const auto& each : cases)
    EXPECT_THAT([&] { merge(each.first, "all"); }, FailsWith(each.second)) << each.first.back();
  EXPECT_THAT([&] { merge({"a", "b"}, "b"); }, FailsWith(ErrorCode::fileExists));
  EXPECT_THAT([&] { undoDrive(folder_ / "a", 1); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { undoDrive(folder_ / "a", 0); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_FALSE(fs::exists(folder_ / "all"));
  EXPECT_TRUE(isAlone("all"));
  EXPECT_EQ(read("a").frames.size(), 60U);
}

TEST_F(MergedDrives, ThatWereKilledLeaveNothingForLong) {
  drive("a", 0, 60);
  drive("b", 10, 60);
  const pid_t dead = fork();
  if (dead == 0) _exit(0);
  waitpid(dead, nullptr, 0);
  const auto draft = [&](const std::string& name, pid_t process) {
    std::string path = partFile(folder_ / name).string();
    const std::string own = "." + std::to_string(getpid()) + ".part";
    return path.replace(path.size() - own.size(), own.size(), "." + std::to_string(process) + ".part");
  };
  const std::string left = draft("all", dead), alive = draft("all", getppid()), other = draft("other", dead);
  for (const std::string& name : {left, left + "-wal", alive, other}) std::ofstream(name) << "x";
  merge({"a", "b"}, "all");
  EXPECT_FALSE(fs::exists(left));
  EXPECT_FALSE(fs::exists(left + "-wal"));
  EXPECT_TRUE(fs::exists(alive));
  EXPECT_TRUE(fs::exists(other));
}

/// A flat with depth, in maps of their own.
class MergedFlats : public testing::Test {
 protected:
  void map(const std::string& name, std::size_t end, const std::string& layers = "places,areas,objects") {
    const fs::path file = folder_ / name;
    MappingSession session =
        fs::exists(file) ? MappingSession::resume(file, labeled_.vocabulary, labeled_.model)
                         : MappingSession::create(file, labeled_.vocabulary, labeled_.model, MapperOptions{});
    WorldOptions options;
    options.layers = layersFrom(layers);
    WorldMapper world(session, options);
    session.beginDrive({.name = name, .posesAreInMap = true});
    world.beginDrive();
    for (std::size_t i = 0; i < end; ++i) {
      Frame frame = flat_.frame(i);
      frame.name = name + std::to_string(session.frames());
      world.observe(frame, labeled_.descriptors.row(i), flat_.image(i), flat_.depth(i), *flat_.intrinsics());
      session.add(frame, labeled_.descriptors.row(i));
    }
    session.finish();
    world.finish();
  }
  MergedMaps merge(const std::string& a, const std::string& b, const std::string& output) const {
    const std::vector<fs::path> maps{folder_ / a, folder_ / b};
    return mergeMaps(maps, folder_ / output);
  }

  /// Names by people.
  static std::vector<std::string> namesOf(const WorldMap& world) {
    std::vector<std::string> names;
    for (const WorldArea& area : world.areas)
      if (!area.givenName.empty()) names.push_back(area.givenName);
    return names;
  }

  const ScratchFolder folder_;
  const test::FlatDrive flat_;
  const DescriptorSequence labeled_ = flat_.labeled();
};

TEST_F(MergedFlats, HaveTheLayersOfAll) {
  map("plain", flat_.size(), "places");
  map("whole", flat_.size() - 1);
  nameArea(folder_ / "whole", "0", "Ada's room");
  const WorldMap whole = readWorld(folder_ / "whole");
  ASSERT_EQ(whole.areas.size(), 3U);
  merge("plain", "whole", "all");
  const WorldMap all = readWorld(folder_ / "all");
  EXPECT_EQ(all.areas.size(), 3U);
  EXPECT_EQ(all.objects.size(), whole.objects.size());
  EXPECT_THAT(namesOf(all), testing::ElementsAre("Ada's room"));
}

TEST_F(MergedFlats, KeepWhatPeopleToldAndTheFirstMapsNameWhereTheyContradictEachOther) {
  for (const std::string name : {"a", "b"}) {
    map(name, flat_.size());
    nameArea(folder_ / name, "0", name + "'s room");
    MapStore store = MapStore::open(folder_ / name, MapStore::Access::write);
    WorldStore(store, MapStore::Access::write)
        .addObjectEdit({ObjectEdit::Kind::name, {1, 1, 1}, {0.5, 0.5, 0.5}, name + "'s chair"});
    store.commit();
  }
  nameArea(folder_ / "b", "1", "den");
  splitArea(folder_ / "b", {2, 0.2}, {2, 3.8});
  requestInterrupt();
  EXPECT_THAT([&] { merge("a", "b", "both"); }, FailsWith(ErrorCode::interrupted));
  EXPECT_TRUE(takeInterrupt());
  EXPECT_THAT(merge("a", "b", "both").conflicts, testing::SizeIs(1));
  EXPECT_THAT(namesOf(readWorld(folder_ / "both")), testing::UnorderedElementsAre("a's room", "den"));
  EXPECT_EQ(sqlite::Database(folder_ / "both", sqlite::Database::Mode::read)
                .number("SELECT count(*) FROM object_edits"),
            2);
}

TEST_F(MergedFlats, KeepAreasAndPeoplesNamesWhereADriveIsUndone) {
  map("flat", flat_.size());
  nameArea(folder_ / "flat", "0", "Ada's room");
  map("flat", flat_.size());
  ASSERT_EQ(readWorld(folder_ / "flat").areas.size(), 3U);
  undoDrive(folder_ / "flat", 0);
  const WorldMap rest = readWorld(folder_ / "flat");
  EXPECT_EQ(rest.places.frames.size(), flat_.size());
  EXPECT_EQ(rest.areas.size(), 3U);
  EXPECT_THAT(namesOf(rest), testing::ElementsAre("Ada's room"));
}

}  // namespace
}  // namespace estancia
