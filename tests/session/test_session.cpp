// Images become a map file while they come; drives through another building.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <random>
#include <set>
#include <stdexcept>

#include "estancia/labelers/labeler.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store.hpp"
#include "estancia/mapper/lost_drive.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/mapper/node_bank.hpp"
#include "estancia/query/ask.hpp"
#include "estancia/query/drives.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/session/session_impl.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

/// Labels an image by the shares of its colors.
class ColorLabeler : public Labeler {
 public:
  const Vocabulary& vocabulary() const override { return vocabulary_; }
  std::string identity() const override { return identity_; }
  bool discovers() const override { return discovers_; }
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override { return {bgr, frame, {}}; }
  LexicalDescriptor infer(const Prepared& prepared) override {
    const cv::Scalar mean = cv::mean(prepared.input);
    const double sum = mean[0] + mean[1] + mean[2];
    return {static_cast<float>(mean[0] / sum), static_cast<float>(mean[1] / sum),
            static_cast<float>(mean[2] / sum)};
  }

  Vocabulary vocabulary_{{"sea", "lawn", "brick"}};
  std::string identity_ = "colors";
  bool discovers_ = false;
};

cv::Mat imageOf(double blue, double green, double red) {
  return cv::Mat(48, 64, CV_8UC3, cv::Scalar(blue, green, red));
}
const cv::Mat sea = imageOf(220, 20, 15), lawn = imageOf(25, 210, 20), brick = imageOf(20, 30, 200);

MapperOptions byHand() {
  MapperOptions options;
  options.distance = "hellinger";
  options.tauJoin = options.tauRevisit = 0.3;
  return options;
}

class LiveMapping : public testing::Test {
 protected:
  test::ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "home.estancia";
  ColorLabeler labeler_;
};

TEST_F(LiveMapping, TellsThePlaceOfEachImageAndIsOnDiskWhenItEnds) {
  {
    MappingSession map(path_, labeler_, byHand());
    EXPECT_EQ(map.add(sea, 1.5, Pose::planar(1, 2, 0)), 0);
    EXPECT_EQ(map.add(lawn), 1);
    EXPECT_EQ(map.add(sea), 0);
    EXPECT_EQ(map.frames(), 3U);
  }
  const TopologicalMap map = readMap(path_);
  ASSERT_EQ(map.frames.size(), 3U);
  EXPECT_EQ(map.frames[1].name, "frame 000001");
  EXPECT_EQ(map.frames[0].timestamp, 1.5);
  EXPECT_EQ(map.frames[0].pose.value().y, 2);
  EXPECT_EQ(map.nodes.size(), 2U);
  const MapStore store = MapStore::open(path_, MapStore::Access::read);
  EXPECT_THAT(store.imageFrames(), ElementsAre(0U, 1U, 2U));
  EXPECT_FALSE(store.image(1).empty()) << "a thumbnail for reports";
  EXPECT_EQ(readMapDescriptors(path_).descriptors.row(1)[1], labeler_.label(lawn)[1]);
}

TEST_F(LiveMapping, TakesPosesThatAreKnownBetterLater) {
  {
    MappingSession map(path_, labeler_, byHand());
    map.add(sea, 0, Pose::planar(1, 2, 0));
    map.add(lawn, 1);
    map.add(brick, 2, Pose::planar(9, 9, 0));
    map.finish();
    map.correct({{0, Pose::planar(3, 4, 0)}, {1, Pose::planar(5, 6, 0)}, {2, std::nullopt}});
    EXPECT_THAT([&] { map.correct({{3, std::nullopt}}); }, FailsWith(ErrorCode::unknownName));
  }
  const TopologicalMap map = readMap(path_);
  EXPECT_EQ(map.frames[0].pose.value().y, 4);
  EXPECT_EQ(map.frames[1].pose.value().x, 5);
  EXPECT_FALSE(map.frames[2].pose);
}

TEST_F(LiveMapping, KnowsPlacesByPosesThatWereMoved) {
  for (const bool moved : {false, true}) {
    test::ScratchFolder folder;
    MapperOptions options = byHand();
    options.tauRevisit = 0.1;
    options.views = 40;
    MappingSession map(folder / "home.estancia", labeler_, options);
    map.add(sea, 0, Pose::planar(50, 0, 0));  // drift
    map.add(lawn, 1, Pose::planar(20, 0, 0));
    if (moved) map.correct({{0, Pose::planar(0, 0, 0)}});
    map.add(sea, 2, Pose::planar(0, 0, 0));
    EXPECT_EQ(map.mapper().nodes(), moved ? 2U : 3U);
  }
}

TEST_F(LiveMapping, CanBeAskedAndLocalizedInMeanwhile) {
  MappingSession map(path_, labeler_, byHand());
  EXPECT_TRUE(map.map().nodes.empty());
  for (const cv::Mat& image : {sea, sea, lawn, lawn, brick, brick}) map.add(image);
  EXPECT_EQ(ask(map.map(), "lawn").places.front().node, 1);
  Localizer localizer(map);
  EXPECT_EQ(localizer.add(labeler_.label(brick)).front().node, 2);
  EXPECT_EQ(map.add(sea), 0) << "and it goes on";
  EXPECT_EQ(localizer.map().frames.size(), 6U) << "as of then";
  map.finish();
  Localizer ofFile(path_);
  EXPECT_EQ(ofFile.map().frames.size(), 7U);
  EXPECT_EQ(ofFile.add(labeler_.label(lawn)).front().node, 1);
}

TEST_F(LiveMapping, GoesOnWithAMapOfThatName) {
  const std::filesystem::path unbroken = folder_ / "unbroken.estancia";
  MappingSession whole(unbroken, labeler_);
  for (int run = 0; run < 2; ++run) {
    MappingSession part(path_, labeler_);
    EXPECT_EQ(part.frames(), whole.frames());
    if (run > 0) whole.beginDrive();
    for (int i = 0; i < 30; ++i) {
      const cv::Mat image = imageOf(i % 7 < 3 ? 200 : 20 + i, 40, i % 7 < 3 ? 20 : 150 + run);
      whole.add(image);
      part.add(image);
    }
  }
  whole.finish();
  const TopologicalMap expected = whole.map(), map = readMap(path_);
  ASSERT_EQ(map.frames.size(), 60U);
  for (std::size_t i = 0; i < map.frames.size(); ++i) EXPECT_EQ(map.frames[i].node, expected.frames[i].node);
  EXPECT_EQ(map.transitions.size(), expected.transitions.size());
}

TEST_F(LiveMapping, LeavesNothingWithoutImagesNorWhenAnErrorEndsIt) {
  { const MappingSession map(path_, labeler_); }
  EXPECT_FALSE(std::filesystem::exists(path_));
  EXPECT_ANY_THROW({
    MappingSession map(path_, labeler_);
    map.add(sea);
    throw std::runtime_error("the camera is gone");
  });
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(LiveMapping, RefusesAnotherModelOtherSettingsAndUnknownWords) {
  MappingSession(path_, labeler_, byHand()).add(sea);
  EXPECT_THAT([&] { MappingSession(path_, labeler_, MapperOptions{}); }, FailsWith(ErrorCode::mismatch));
  ColorLabeler other;
  other.identity_ = "other colors";
  EXPECT_THAT([&] { MappingSession(path_, other); }, FailsWith(ErrorCode::mismatch));
  other = ColorLabeler();
  other.vocabulary_ = Vocabulary({"a", "b", "c"});
  EXPECT_THAT([&] { MappingSession(path_, other); }, FailsWith(ErrorCode::mismatch));
  other.discovers_ = true;
  EXPECT_THAT([&] { MappingSession(path_, other); }, FailsWith(ErrorCode::invalidInput));
  auto ofDescriptors = MappingSession::resume(path_, labeler_.vocabulary(), "colors");
  EXPECT_THAT([&] { ofDescriptors.add(sea); }, FailsWith(ErrorCode::invalidState));
}

TEST_F(LiveMapping, ReplacesAMapOnlyWhenAsked) {
  MappingSession(path_, labeler_, byHand()).add(sea);
  EXPECT_THAT([&] { MappingSession::create(path_, labeler_.vocabulary(), "colors", {}); },
              FailsWith(ErrorCode::fileExists));
  auto map = MappingSession::create(path_, labeler_.vocabulary(), "colors", byHand(), ExistingMap::replace);
  Frame frame;
  frame.name = "first";
  map.add(frame, labeler_.label(lawn));
  map.finish();
  EXPECT_EQ(readMap(path_).frames.front().name, "first");
}

/// Drives through six places by day, in the evening, and in the evening again.
class Evenings : public testing::Test {
 protected:
  static constexpr std::size_t labels = 80;
  static Vocabulary words() {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < labels; ++i) names.push_back("word " + std::to_string(i));
    return Vocabulary(names);
  }
  std::vector<float> image(std::size_t place, bool isEvening) {
    std::vector<float> p = places_.image(place);
    if (!isEvening) return p;
    const std::vector<float> light = lights_.image(place);
    float sum = 0;
    for (std::size_t i = 0; i < labels; ++i) sum += p[i] = std::pow(p[i], 0.57F) * std::pow(light[i], 0.43F);
    for (float& value : p) value /= sum;
    return p;
  }
  void drive(MappingSession& session, bool isEvening) {
    if (session.frames() > 0) session.beginDrive();
    for (std::size_t i = 0; i < 72; ++i) {
      Frame frame;
      frame.name = std::to_string(session.frames());
      frame.pose = Pose::planar(2.0 * static_cast<double>(i / 6 % 6), 0, 0);
      session.add(frame, image(i / 6 % 6, isEvening));
    }
  }

  test::ScratchFolder folder_;
  test::SyntheticPlaces places_{6, labels, 0.4}, lights_{6, labels, 0.1, 11};
};

TEST_F(Evenings, AreModesOfTheirPlaces) {
  {
    MappingSession session = MappingSession::create(folder_ / "map", words(), "test", {});
    for (const bool isEvening : {false, true, true}) drive(session, isEvening);
    session.finish();
    EXPECT_EQ(session.mapper().nodes(), 6U);
  }
  const MapStore store = MapStore::open(folder_ / "map", MapStore::Access::read);
  Mapper mapper = restoreMapper(store);
  mapper.impl().endModes();
  const NodeBank& bank = mapper.impl().bank;
  EXPECT_EQ(bank.rows(), bank.size() * 3) << "day and evening, and the mean";
  const Distance distance = getDistance("standardized-clr");
  for (std::size_t place = 0; place < 6; ++place) {
    std::vector<float> embedded(labels);
    embed(distance.embedding, image(place, true), embedded, distance.parts);
    const std::vector<float> seen = bank.compared(embedded);
    const auto found = bank.nearest(seen, bank.size());
    EXPECT_EQ(bank[found->slot].id, static_cast<int>(place));
    EXPECT_LT(found->distance, 1 - dot(bank.mean(found->slot), seen)) << "nearer than the mean";
  }
}

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
  for (const MapBudget& budget : {MapBudget{.memory = 50, .file = 50}, {}}) {
    MappingSession map = begin(home_);
    map.setBudget(budget);
    const auto before = statesOfFirst();
    drive(map, "office", office_);
    EXPECT_EQ(placesOf(1), alone);
    EXPECT_EQ(statesOfFirst(), before);
  }
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
