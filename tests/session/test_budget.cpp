// Budgets: a map keeps its size and its memory, whatever is mapped, and still knows its places.
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <vector>

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

MapBudget ofFile(std::uint64_t megabytes) {
  return {std::nullopt, megabytes};
}
MapBudget ofMemory(std::uint64_t megabytes) {
  return {megabytes, std::nullopt};
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

  /// The map of one drive in several runs of so many frames.
  TopologicalMap mapped(const MapBudget& budget, const std::vector<std::size_t>& runs) {
    fs::remove(path_);
    random_.seed(3);
    for (const std::size_t frames : runs) {
      MappingSession map =
          fs::exists(path_) ? MappingSession::resume(path_, budgetWords(), "model") : session(budget);
      EXPECT_EQ(map.budget(), budget) << "the map keeps it";
      driveThrough(map, places_, frames, random_);
    }
    return readMap(path_);
  }

  static void expectSamePlaces(const TopologicalMap& a, const TopologicalMap& b) {
    ASSERT_EQ(a.nodes.size(), b.nodes.size());
    for (std::size_t i = 0; i < a.nodes.size(); ++i) {
      EXPECT_EQ(a.nodes[i].frames, b.nodes[i].frames);
      EXPECT_EQ(a.nodes[i].mean, b.nodes[i].mean);
    }
  }
};

TEST_F(Budget, TheFileStaysWithinItAndPlacesAreTheSameAsWithoutIt) {
  const MapBudget budget{.memory = 5, .file = 2};
  const TopologicalMap map = mapped(budget, {5000});
  EXPECT_LE(fs::file_size(path_), 2'150'000U);
  EXPECT_GE(fs::file_size(path_), 1'500'000U) << "what there is room for is kept";
  EXPECT_TRUE(map.isThinned());
  EXPECT_EQ(map.frames.back().name, "004999");
  EXPECT_EQ(map.nodes.size(), 12U);
  std::map<int, std::size_t> framesOf;
  for (const MappedFrame& frame : map.frames) ++framesOf[frame.node];
  for (const Node& node : map.nodes) EXPECT_GE(framesOf[node.id], 5U) << node.id;
  EXPECT_EQ(map.decisions.size(), map.frames.size());
  for (std::size_t i = 0; i < map.decisions.size(); ++i) EXPECT_EQ(map.decisions[i].frame, i);

  const TopologicalMap resumed = mapped(budget, {4000, 1000});
  EXPECT_LE(fs::file_size(path_), 2'150'000U);
  expectSamePlaces(resumed, map);

  const TopologicalMap whole = mapped({}, {5000});
  EXPECT_LT(map.frames.size(), whole.frames.size() / 2);
  expectSamePlaces(map, whole);
  for (const MappedFrame& frame : map.frames) {
    EXPECT_EQ(frame.node, whole.frames[frame.number].node);
    EXPECT_EQ(frame.room, whole.frames[frame.number].room);
  }
}

TEST_F(Budget, CanBeLifted) {
  mapped({.memory = 5, .file = 2}, {3000});
  {
    MappingSession map = MappingSession::resume(path_, budgetWords(), "model");
    map.changeBudget([](MapBudget& kept) { kept.file.reset(); });
    EXPECT_EQ(map.budget().memory, 5U);
    driveThrough(map, places_, 1500, random_);
  }
  EXPECT_GE(fs::file_size(path_), 3'000'000U) << "nothing is left out any more";
}

TEST_F(Budget, AnotherDriveIsRecognizedInAThinnedMap) {
  MappingSession map = session(ofFile(2));
  driveThrough(map, places_, 4000, random_);
  map.beginDrive();
  driveThrough(map, places_, 400, random_);
  map.finish();
  const TopologicalMap found = readMap(path_);
  ASSERT_EQ(found.drives.size(), 2U);
  EXPECT_EQ(found.frames[found.drives[1].firstFrame].number, 4000U);
  EXPECT_EQ(found.nodes.size(), 12U);
}

TEST_F(Budget, ThatIsTooSmallIsAnError) {
  const ManyPlaces many(400);
  {
    MappingSession map = session(ofFile(2));
    const auto driveOn = [&] {
      for (int i = 0; i < 40; ++i) {
        driveThrough(map, many, 1000, random_);
        map.finish();
      }
    };
    EXPECT_THAT(driveOn, FailsWith(ErrorCode::tooLarge)) << "an image a place does not fit into the file";
  }
  EXPECT_FALSE(readMap(path_).nodes.empty()) << "the map is whole";
  fs::remove(path_);
  MappingSession map = session(ofMemory(1));
  EXPECT_THAT([&] { driveThrough(map, many, 20000, random_); }, FailsWith(ErrorCode::tooLarge))
      << "all places are in use";
  EXPECT_THAT([&] { map.setBudget(ofMemory(0)); }, FailsWith(ErrorCode::invalidOption));

  std::vector<std::string> names;
  for (int i = 0; i < 20000; ++i) names.push_back(fmt::format("label {}", i));
  MappingSession wide =
      MappingSession::create(folder_ / "wide.estancia", Vocabulary(names), "model", budgetOptions());
  EXPECT_THAT([&] { wide.setBudget(ofMemory(10)); }, FailsWith(ErrorCode::tooLarge)) << "no place fits";
}

TEST_F(Budget, MemoryTakesRarelyUsedPlacesIntoTheirNeighbors) {
  const ManyPlaces many(120);
  MappingSession map = session(ofMemory(1));  // some 20 places of 200 labels
  driveThrough(map, places_, 2000, random_);
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

TEST_F(Budget, CompactingLeavesOutTheSame) {
  const TopologicalMap before = mapped({}, {4000});
  const CompactedMap done = compactMap(path_, 2);
  EXPECT_GT(done.bytesBefore, 3'000'000U);
  EXPECT_LE(done.bytesAfter, 2'000'000U);
  EXPECT_GE(done.bytesAfter, 1'500'000U);
  EXPECT_EQ(done.bytesAfter, fs::file_size(path_));
  EXPECT_EQ(done.framesBefore, 4000U);
  const TopologicalMap after = readMap(path_);
  EXPECT_EQ(after.frames.size(), done.framesAfter);
  expectSamePlaces(after, before);
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
  mapped({}, {2000});
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
  const CompactedMap done = compactMap(path_, 3);  // half of a frame is its room evidence
  EXPECT_LE(done.bytesAfter, 3'000'000U);
  EXPECT_GE(done.bytesAfter, 2'100'000U) << "and no more is left out than must be";
}

TEST_F(Budget, CompactingAnUnbrokenMapGivesUnusedSpaceBack) {
  mapped({}, {300});
  const CompactedMap done = compactMap(path_, std::nullopt);
  EXPECT_LE(done.bytesAfter, done.bytesBefore);
  EXPECT_EQ(done.framesAfter, 300U);
  EXPECT_EQ(readMap(path_).frames.size(), 300U);
  EXPECT_THAT([&] { compactMap(folder_ / "none.estancia", std::nullopt); },
              FailsWith(ErrorCode::fileNotFound));
}

}  // namespace
}  // namespace estancia
