// Budgets: a map keeps its size and its memory, whatever is mapped, and still knows its places.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/map_budget.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include "estancia/localization/localizer.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/session/session.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;

constexpr std::size_t budgetLabels = 200;

/// ManyPlaces that look different, whose images vary.
class ManyPlaces {
 public:
  explicit ManyPlaces(std::size_t count) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    for (std::size_t p = 0; p < count; ++p) {
      logits_.emplace_back();
      for (std::size_t i = 0; i < budgetLabels; ++i) logits_.back().push_back(2 * normal(random));
    }
  }
  LexicalDescriptor image(std::size_t place, std::mt19937& random) const {
    std::normal_distribution<float> normal;
    LexicalDescriptor p(budgetLabels);
    float sum = 0;
    for (std::size_t i = 0; i < budgetLabels; ++i)
      sum += p[i] = std::exp(logits_[place][i] + 0.5F * normal(random));
    for (float& value : p) value /= sum;
    return p;
  }
  std::size_t size() const { return logits_.size(); }

 private:
  std::vector<std::vector<float>> logits_;
};

Vocabulary budgetWords() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < budgetLabels; ++i) names.push_back(fmt::format("label {}", i));
  return Vocabulary(names);
}

MapperOptions budgetOptions() {
  MapperOptions options;
  options.distance = "hellinger";
  options.tauJoin = options.tauRevisit = 0.45;
  options.views = 40;
  return options;
}

/// Goes through the places, some twenty frames in each; a pose where it stands.
void driveThrough(MappingSession& session, const ManyPlaces& places, std::size_t frames,
                  std::mt19937& random) {
  std::size_t place = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    if (i % 20 == 0) place = random() % places.size();
    Frame frame;
    frame.name = fmt::format("{:06}", session.frames());
    frame.room = fmt::format("room {}", place);
    frame.pose = Pose::planar(3 * static_cast<double>(place), 0.01 * static_cast<double>(i % 20), 0);
    session.add(frame, places.image(place, random));
  }
}

class Budget : public testing::Test {
 protected:
  test::ScratchFolder folder_;
  const fs::path path_ = folder_ / "home.estancia";
  const ManyPlaces places_{12};
  std::mt19937 random_{3};

  MappingSession session(const MapBudget& budget) const {
    MappingSession made = MappingSession::create(path_, budgetWords(), "model", budgetOptions());
    made.setBudget(budget);
    return made;
  }
};

TEST_F(Budget, TheFileStaysWithinIt) {
  MapBudget budget;
  budget.file = 2;
  {
    MappingSession map = session(budget);
    for (int part = 0; part < 4; ++part) {
      driveThrough(map, places_, 5000, random_);
      map.finish();
      EXPECT_LE(fs::file_size(path_), 2'150'000U) << part;
    }
    EXPECT_EQ(map.frames(), 20000U);
    EXPECT_EQ(map.mapper().nodes(), 12U);
  }
  EXPECT_GE(fs::file_size(path_), 1'500'000U) << "what there is room for is kept";
  const TopologicalMap map = readMap(path_);
  EXPECT_TRUE(map.isThinned());
  EXPECT_EQ(map.frames.back().number, 19999U);
  EXPECT_EQ(map.frames.back().name, "019999");
  std::map<int, std::set<std::string>> roomsOf;
  std::map<int, std::size_t> framesOf;
  for (const MappedFrame& frame : map.frames) {
    roomsOf[frame.node].insert(frame.room);
    ++framesOf[frame.node];
  }
  EXPECT_EQ(roomsOf.size(), 12U);
  for (const auto& [node, rooms] : roomsOf) EXPECT_EQ(rooms.size(), 1U) << "frames are where they were";
  std::uint64_t mapped = 0;
  for (const Node& node : map.nodes) {
    mapped += node.frames;
    EXPECT_GE(framesOf[node.id], 5U) << node.id;
  }
  EXPECT_EQ(mapped, 20000U) << "places remember all of their frames";
  EXPECT_EQ(map.decisions.size(), map.frames.size());
  for (std::size_t i = 0; i < map.decisions.size(); ++i) EXPECT_EQ(map.decisions[i].frame, i);
}

TEST_F(Budget, PlacesAreTheSameAsWithoutIt) {
  MapBudget budget;
  budget.file = 2;
  {
    MappingSession map = session(budget);
    driveThrough(map, places_, 5000, random_);
  }
  const TopologicalMap bounded = readMap(path_);
  fs::remove(path_);
  random_.seed(3);
  {
    MappingSession map = session({});
    driveThrough(map, places_, 5000, random_);
  }
  const TopologicalMap whole = readMap(path_);
  EXPECT_LT(bounded.frames.size(), whole.frames.size() / 2);
  ASSERT_EQ(bounded.nodes.size(), whole.nodes.size());
  for (std::size_t i = 0; i < whole.nodes.size(); ++i) {
    EXPECT_EQ(bounded.nodes[i].frames, whole.nodes[i].frames);
    EXPECT_EQ(bounded.nodes[i].mean, whole.nodes[i].mean);
  }
  for (const MappedFrame& frame : bounded.frames) EXPECT_EQ(frame.node, whole.frames[frame.number].node);
}

TEST_F(Budget, IsKeptByTheMap) {
  MapBudget budget;
  budget.file = 2;
  budget.memory = 5;
  {
    MappingSession map = session(budget);
    driveThrough(map, places_, 3000, random_);
  }
  {
    MappingSession map = MappingSession::resume(path_, budgetWords(), "model");
    EXPECT_EQ(map.budget(), budget);
    driveThrough(map, places_, 3000, random_);
    map.finish();
    EXPECT_EQ(map.frames(), 6000U);
  }
  EXPECT_LE(fs::file_size(path_), 2'150'000U);
  {
    MappingSession map = MappingSession::resume(path_, budgetWords(), "model");
    map.changeBudget([](MapBudget& kept) { kept.file.reset(); });
    EXPECT_EQ(map.budget().memory, 5U);
    driveThrough(map, places_, 1500, random_);
  }
  EXPECT_GE(fs::file_size(path_), 3'000'000U) << "nothing is left out any more";
}

TEST_F(Budget, GoesOnAsAnUnbrokenRun) {
  MapBudget budget;
  budget.file = 2;
  {
    MappingSession map = session(budget);
    driveThrough(map, places_, 4000, random_);
    driveThrough(map, places_, 1000, random_);
  }
  const TopologicalMap whole = readMap(path_);
  fs::remove(path_);
  random_.seed(3);
  {
    MappingSession map = session(budget);
    driveThrough(map, places_, 4000, random_);
  }
  {
    MappingSession map = MappingSession::resume(path_, budgetWords(), "model");
    driveThrough(map, places_, 1000, random_);
  }
  const TopologicalMap resumed = readMap(path_);
  ASSERT_EQ(resumed.nodes.size(), whole.nodes.size());
  for (std::size_t i = 0; i < whole.nodes.size(); ++i) {
    EXPECT_EQ(resumed.nodes[i].frames, whole.nodes[i].frames);
    EXPECT_EQ(resumed.nodes[i].mean, whole.nodes[i].mean);
  }
}

TEST_F(Budget, AnotherDriveIsRecognizedInAThinnedMap) {
  MapBudget budget;
  budget.file = 2;
  MappingSession map = session(budget);
  driveThrough(map, places_, 6000, random_);
  map.beginDrive();
  driveThrough(map, places_, 400, random_);
  map.finish();
  const TopologicalMap found = readMap(path_);
  ASSERT_EQ(found.drives.size(), 2U);
  EXPECT_EQ(found.frames[found.drives[1].firstFrame].number, 6000U);
  EXPECT_EQ(found.nodes.size(), 12U);
}

TEST_F(Budget, TooSmallForOneImageAPlaceIsAnError) {
  const ManyPlaces many(400);
  MapBudget budget;
  budget.file = 2;
  MappingSession map = session(budget);
  EXPECT_THAT(
      [&] {
        for (int i = 0; i < 40; ++i) {
          driveThrough(map, many, 1000, random_);
          map.finish();
        }
      },
      FailsWith(ErrorCode::tooLarge, "home.estancia", "--file-budget 2 ", "larger"));
  const TopologicalMap kept = readMap(path_);
  EXPECT_FALSE(kept.nodes.empty()) << "the map is whole";
}

TEST_F(Budget, MemoryTakesRarelyUsedPlacesIntoTheirNeighbors) {
  const ManyPlaces many(120);
  MapBudget budget;
  budget.memory = 1;  // some 20 places of 200 labels
  MappingSession map = session(budget);
  driveThrough(map, places_, 6000, random_);
  ASSERT_EQ(map.mapper().nodes(), 12U);
  std::set<int> used;
  for (const Node& node : map.map().nodes) used.insert(node.id);
  for (std::size_t place = 12; place < 120; ++place) {  // one image each
    Frame frame;
    frame.name = fmt::format("{:06}", map.frames());
    map.add(frame, many.image(place, random_));
  }
  map.finish();
  const TopologicalMap found = map.map();
  EXPECT_LT(found.nodes.size(), 50U);
  EXPECT_GT(found.nodes.size(), 13U);
  for (const int id : used) EXPECT_NE(found.findNode(id), nullptr) << "the robot uses it";
  EXPECT_FALSE(found.merges.empty());
  EXPECT_TRUE(std::ranges::any_of(found.merges, [](const Merge& m) { return std::isinf(m.threshold); }));
  for (const Transition& transition : found.transitions) EXPECT_NE(transition.from, transition.to);
}

TEST_F(Budget, MemoryForPlacesThatAreAllUsedIsAnError) {
  const ManyPlaces many(120);
  MapBudget budget;
  budget.memory = 1;
  MappingSession map = session(budget);
  EXPECT_THAT([&] { driveThrough(map, many, 20000, random_); },
              FailsWith(ErrorCode::tooLarge, "places", "--memory"));
}

TEST_F(Budget, TooLittleMemoryIsSaidAtOnce) {
  std::vector<std::string> names;
  for (int i = 0; i < 20000; ++i) names.push_back(fmt::format("label {}", i));
  MappingSession map = MappingSession::create(path_, Vocabulary(names), "model", budgetOptions());
  MapBudget budget;
  budget.memory = 10;
  EXPECT_THAT([&] { map.setBudget(budget); }, FailsWith(ErrorCode::tooLarge, "10 MB", "20000 labels"));
  budget.memory = 0;
  EXPECT_THAT([&] { map.setBudget(budget); }, FailsWith(ErrorCode::invalidOption, "memory"));
}

TEST_F(Budget, CompactingLeavesOutTheSame) {
  {
    MappingSession map = session({});
    driveThrough(map, places_, 4000, random_);
  }
  const TopologicalMap before = readMap(path_);
  const CompactedMap done = compactMap(path_, 2);
  EXPECT_GT(done.bytesBefore, 3'000'000U);
  EXPECT_LE(done.bytesAfter, 2'000'000U);
  EXPECT_GE(done.bytesAfter, 1'500'000U);
  EXPECT_EQ(done.bytesAfter, fs::file_size(path_));
  EXPECT_EQ(done.framesBefore, 4000U);
  const TopologicalMap after = readMap(path_);
  EXPECT_EQ(after.frames.size(), done.framesAfter);
  ASSERT_EQ(after.nodes.size(), before.nodes.size());
  for (std::size_t i = 0; i < before.nodes.size(); ++i) EXPECT_EQ(after.nodes[i].mean, before.nodes[i].mean);
  EXPECT_EQ(after.transitions.size(), before.transitions.size());
  // It can be localized in, and gone on with.
  Localizer localizer(path_);
  std::size_t right = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    const std::size_t place = i / 10;
    const auto found = localizer.add(places_.image(place, random_)).front();
    right += localizer.map().frames[found.nearestImage].room == fmt::format("room {}", place);
  }
  EXPECT_GE(right, 98U);
  MappingSession map = MappingSession::resume(path_, budgetWords(), "model");
  driveThrough(map, places_, 100, random_);
  EXPECT_EQ(map.frames(), 4100U);
}

TEST_F(Budget, CompactingCountsWhatImagesTellOfRooms) {
  {
    MappingSession map = session({});
    driveThrough(map, places_, 2000, random_);
  }
  constexpr std::size_t rooms = 40, told = 8;
  RoomPredictions predictions{"by name", std::vector<std::string>(rooms, "room"), DescriptorMatrix(rooms)};
  for (std::size_t i = 0; i < 2000; ++i) {
    predictions.probabilities.append(std::vector<float>(rooms, 1.0F / rooms));
    for (std::size_t label = 0; label < told; ++label)
      predictions.evidence.push_back({i, label, std::vector<float>(rooms, 0.5F)});
  }
  writeRoomPredictions(predictions, path_);
  const std::uint64_t before = fs::file_size(path_);
  EXPECT_GT(before, 4'000'000U);
  const CompactedMap done = compactMap(path_, 3);  // half of a frame is what it tells of rooms
  EXPECT_LE(done.bytesAfter, 3'000'000U);
  EXPECT_GE(done.bytesAfter, 2'100'000U) << "and no more is left out than must be";
}

TEST_F(Budget, CompactingAnUnbrokenMapGivesUnusedSpaceBack) {
  {
    MappingSession map = session({});
    driveThrough(map, places_, 300, random_);
  }
  const CompactedMap done = compactMap(path_, std::nullopt);
  EXPECT_LE(done.bytesAfter, done.bytesBefore);
  EXPECT_EQ(done.framesAfter, 300U);
  EXPECT_EQ(readMap(path_).frames.size(), 300U);
  EXPECT_THAT([&] { compactMap(folder_ / "none.estancia", std::nullopt); },
              FailsWith(ErrorCode::fileNotFound, "none.estancia"));
}

}  // namespace
}  // namespace estancia
