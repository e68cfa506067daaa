// A drive through another building: it has the places that it has alone, and touches none of the map's.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/lost_drive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include "estancia/map_file/store.hpp"
#include "estancia/query/drives.hpp"
#include "estancia/session/session.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

constexpr std::size_t wordCount = 60, roomCount = 8;

Vocabulary wordsOfBuildings() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < wordCount; ++i) names.push_back("word " + std::to_string(i));
  return Vocabulary(names);
}

/// All of its rooms have something in common that no other building has.
class Building {
 public:
  explicit Building(unsigned seed) : rooms_(roomCount, wordCount, 0.6, seed) {
    std::mt19937 random(seed + 100);
    std::normal_distribution<float> normal(0, 3);
    for (std::size_t i = 0; i < wordCount; ++i) style_.push_back(std::exp(normal(random)));
  }

  /// `rounds` through all of the rooms, a few images in each.
  std::vector<std::vector<float>> drive(std::size_t rounds) {
    std::vector<std::vector<float>> images;
    for (std::size_t i = 0; i < 6 * roomCount * rounds; ++i) {
      std::vector<float>& image = images.emplace_back(rooms_.image(i / 6 % roomCount));
      float sum = 0;
      for (std::size_t l = 0; l < wordCount; ++l) sum += image[l] *= style_[l];
      for (float& p : image) p /= sum;
    }
    return images;
  }

 private:
  test::SyntheticPlaces rooms_;
  std::vector<float> style_;
};

class AnotherBuilding : public testing::Test {
 protected:
  MappingSession begin(const std::vector<std::vector<float>>& images) {
    MappingSession map = MappingSession::create(path_, wordsOfBuildings(), "test", {}, ExistingMap::replace);
    drive(map, "first", images);
    return map;
  }
  static void add(MappingSession& map, const std::vector<float>& image) {
    Frame frame;
    frame.name = "frame " + std::to_string(map.frames());
    map.add(frame, image);
  }
  static void drive(MappingSession& map, const std::string& name,
                    const std::vector<std::vector<float>>& images) {
    map.beginDrive({name});
    for (const auto& image : images) add(map, image);
    map.finish();
  }
  /// The places of a drive's images, numbered as they come.
  std::vector<int> placesOf(std::size_t number) const {
    const TopologicalMap map = readMap(path_);
    const std::size_t begin = map.drives[number].firstFrame;
    const std::size_t end =
        number + 1 < map.drives.size() ? map.drives[number + 1].firstFrame : map.frames.size();
    std::map<int, int> numbers;
    std::vector<int> found;
    for (std::size_t i = begin; i < end; ++i)
      found.push_back(numbers.emplace(map.frames[i].node, static_cast<int>(numbers.size())).first->second);
    return found;
  }
  std::vector<std::string> statesOfFirst() const {
    std::set<int> own;
    const TopologicalMap map = readMap(path_);
    const std::size_t end = map.drives.size() > 1 ? map.drives[1].firstFrame : map.frames.size();
    for (std::size_t i = 0; i < end; ++i) own.insert(map.frames[i].node);
    std::vector<std::string> states;
    for (const auto& [id, state] : MapStore::open(path_, MapStore::Access::read).nodeStates())
      if (own.contains(id)) states.push_back(state);
    return states;
  }

  test::ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "map.estancia";
  const std::vector<std::vector<float>> home_ = Building(1).drive(4), office_ = Building(2).drive(3);
};

TEST_F(AnotherBuilding, HasThePlacesThatItHasAlone) {
  begin(office_);
  const std::vector<int> alone = placesOf(0);
  EXPECT_EQ(*std::ranges::max_element(alone) + 1, static_cast<int>(roomCount));
  MappingSession map = begin(home_);
  const auto before = statesOfFirst();
  drive(map, "office", office_);
  EXPECT_EQ(placesOf(1), alone);
  EXPECT_EQ(statesOfFirst(), before);
  const TopologicalMap found = readMap(path_);
  EXPECT_FALSE(summarizeDrives(found)[1].recognized);
  EXPECT_EQ(found.nodes.size(), 2 * roomCount);
  EXPECT_EQ(found.decisions.size(), home_.size() + office_.size());
  for (std::size_t i = home_.size(); i < found.frames.size(); ++i)
    EXPECT_EQ(found.decisions[i].frame, i) << "explained as it was mapped at last";
  for (const Transition& transition : found.transitions)
    EXPECT_EQ(transition.from < found.frames[home_.size()].node,
              transition.to < found.frames[home_.size()].node);
}

TEST_F(AnotherBuilding, IsKnownAgainAndSoIsTheFirst) {
  Building home(1), office(2);
  MappingSession map = begin(home.drive(4));
  drive(map, "office", office.drive(3));
  drive(map, "office again", office.drive(2));
  drive(map, "home again", home.drive(2));
  const TopologicalMap found = readMap(path_);
  std::vector<std::set<int>> seen(4);
  for (std::size_t number = 0; number < 4; ++number)
    for (std::size_t i = found.drives[number].firstFrame;
         i < (number < 3 ? found.drives[number + 1].firstFrame : found.frames.size()); ++i)
      seen[number].insert(found.frames[i].node);
  EXPECT_EQ(seen[0].size(), roomCount) << "what is told apart by its own scale stays apart";
  EXPECT_EQ(seen[1].size(), roomCount);
  const auto shared = [&](std::size_t a, std::size_t b) {
    std::vector<int> both;
    std::ranges::set_intersection(seen[a], seen[b], std::back_inserter(both));
    return both.size();
  };
  EXPECT_EQ(shared(0, 1) + shared(0, 2) + shared(1, 3), 0U);
  EXPECT_GE(shared(1, 2), roomCount / 2);
  EXPECT_GE(shared(0, 3), roomCount / 2);
}

TEST_F(AnotherBuilding, GoesOnAfterACrashAsIfNothingHadHappened) {
  begin(office_);
  const std::vector<int> alone = placesOf(0);
  for (const std::size_t crash : {7UL, 50UL}) {
    try {
      MappingSession map = begin(home_);
      map.beginDrive({"office"});
      for (std::size_t i = 0; i < crash; ++i) add(map, office_[i]);
      if (crash == 7)
        map.finish();
      else
        map.map();  // is written
      throw std::runtime_error("killed");
    } catch (const std::runtime_error&) {
    }
    MappingSession map = MappingSession::resume(path_, wordsOfBuildings(), "test");
    for (std::size_t i = crash; i < office_.size(); ++i) add(map, office_[i]);
    map.finish();
    EXPECT_EQ(placesOf(1), alone) << crash;
  }
}

TEST_F(AnotherBuilding, IsLeftWithoutATraceInTheNext) {
  Building home(1), office(2);
  const auto first = office.drive(3), then = home.drive(3);
  MappingSession map = begin(home.drive(4));
  map.beginDrive({"from the office to the home"});
  for (const auto& image : first) add(map, image);
  for (const auto& image : then) add(map, image);
  map.finish();
  const TopologicalMap found = readMap(path_);
  std::map<int, std::set<std::size_t>> roomsOf;
  std::set<int> known;
  std::size_t back = 0;
  const std::size_t begin = found.drives[1].firstFrame;
  for (std::size_t i = 0; i < begin; ++i) known.insert(found.frames[i].node);
  for (std::size_t i = begin; i < found.frames.size(); ++i) {
    const bool isHome = i >= begin + first.size();
    roomsOf[found.frames[i].node].insert((isHome ? 100 : 0) + (i - begin) / 6 % roomCount);
    if (isHome && known.contains(found.frames[i].node)) ++back;
    EXPECT_FALSE(!isHome && known.contains(found.frames[i].node)) << i;
  }
  for (const auto& [node, rooms] : roomsOf) EXPECT_EQ(rooms.size(), 1U) << node;
  EXPECT_GE(back, then.size() / 2);
  for (const Merge& merge : found.merges)
    EXPECT_FALSE(known.contains(merge.kept) && merge.frame > begin) << merge.absorbed;
}

}  // namespace
}  // namespace estancia
