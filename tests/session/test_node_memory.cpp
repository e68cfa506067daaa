// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/node_memory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/session/session.hpp"
#include "estancia/session/session_impl.hpp"
#include "support/support.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

using Look = std::vector<float>;

double apart(const Moments& a, const Moments& b) {
  return std::abs(a.mean()[0] - b.mean()[0]);
}

/// A node of two values whose mean is what it is compared by.
class Modes : public testing::Test {
 protected:
  void drive(const Look& look, int frames, double threshold = 0.1) {
    for (int i = 0; i < frames; ++i) {
      if (isFurther_) {
        if (!node_.own) node_.own.emplace(2, false);
        node_.own->add(look);
      }
      ++node_.frames;
      node_.probabilities.add(look);
    }
    node_.endDrive(threshold, 3, apart);
    isFurther_ = true;
  }
  std::vector<float> looks() const {
    std::vector<float> first;
    for (const Moments* look : node_.looks()) first.push_back(std::round(look->mean()[0] * 1000) / 1000);
    return first;
  }

  NodeMemory node_{0, 0, 0, Moments(2, true), std::nullopt};
  bool isFurther_ = false;
};

TEST_F(Modes, AreNoneWhereAllDrivesSeeTheSame) {
  drive({0.5F, 0.5F}, 10);
  EXPECT_THAT(looks(), testing::ElementsAre(0.5F));
  drive({0.52F, 0.48F}, 10);
  EXPECT_THAT(looks(), testing::ElementsAre(0.51F));
}

TEST_F(Modes, AreTheMeansOfDrivesInOtherLight) {
  drive({0.5F, 0.5F}, 10);
  drive({0.8F, 0.2F}, 30);
  EXPECT_THAT(looks(), testing::ElementsAre(0.725F, 0.5F, 0.8F));
  drive({0.54F, 0.46F}, 10);
  EXPECT_THAT(looks(), testing::ElementsAre(0.688F, 0.52F, 0.8F)) << "the day again";
  drive({0.1F, 0.9F}, 2);
  EXPECT_EQ(looks().size(), 3U) << "two frames may be anything";
}

TEST_F(Modes, AreFewAndTheNearestBecomeOne) {
  for (const float look : {0.1F, 0.5F, 0.9F, 0.3F, 0.71F}) drive({look, 1 - look}, 10);
  EXPECT_EQ(looks().size(), 1 + NodeMemory::mostModes);
  drive({0.5F, 0.5F}, 10, 2);
  EXPECT_EQ(looks().size(), 1U) << "within the threshold";
}

TEST_F(Modes, OfFewFramesAreJoinedWhateverTheDistance) {
  node_.modes.assign(1, Moments(2, false));
  node_.modes[0].add(Look{1000, 0}, 10);
  for (const float look : {0.1F, 0.9F}) {
    node_.modes.emplace_back(2, false);
    node_.modes.back().add(Look{look, 0}, look < 0.5F ? 2 : 10);
  }
  node_.joinModes(0.1, 3, apart);
  EXPECT_EQ(node_.modes.size(), 2U);
}

TEST_F(Modes, OfTwoNodesAreThoseOfOne) {
  drive({0.5F, 0.5F}, 10);
  Modes::drive({0.8F, 0.2F}, 10);
  NodeMemory other{1, 0, 0, Moments(2, true), std::nullopt};
  for (int i = 0; i < 4; ++i) {
    ++other.frames;
    other.probabilities.add(Look{0.2F, 0.8F});
  }
  node_.mergeOfOtherDrives(other);
  EXPECT_THAT(looks(), testing::ElementsAre(testing::_, 0.5F, 0.8F, 0.2F));
  EXPECT_EQ(node_.frames, 24U);
  NodeMemory same{2, 0, 0, Moments(2, true), std::nullopt};
  same.merge(other);
  EXPECT_EQ(same.looks().size(), 1U);
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
  MappingSession open(const std::string& map) const {
    return std::filesystem::exists(folder_ / map)
               ? MappingSession::resume(folder_ / map, words(), "test")
               : MappingSession::create(folder_ / map, words(), "test", {});
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
  void drive(MappingSession& session, bool isEvening, std::size_t begin = 0, std::size_t end = 72) {
    if (begin == 0 && session.frames() > 0) session.beginDrive();
    for (std::size_t i = begin; i < end; ++i) {
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
    MappingSession session = open("map");
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

TEST_F(Evenings, OfAnInterruptedRunAreThoseOfAnUnbrokenOne) {
  std::map<std::string, std::vector<std::string>> states;
  for (const std::string map : {"unbroken", "interrupted"}) {
    places_ = test::SyntheticPlaces(6, labels, 0.4);
    lights_ = test::SyntheticPlaces(6, labels, 0.1, 11);
    std::optional<MappingSession> session = open(map);
    for (const bool isEvening : {false, true, false, true})
      for (const std::size_t half : {0U, 36U}) {
        drive(*session, isEvening, half, half + 36);
        if (map == "unbroken") continue;
        session->finish();
        session.reset();
        session = open(map);
      }
    session->finish();
    session.reset();
    const MapStore store = MapStore::open(folder_ / map, MapStore::Access::read);
    for (const auto& [id, state] : store.nodeStates()) states[map].push_back(state);
  }
  EXPECT_EQ(states["interrupted"], states["unbroken"]);
}

}  // namespace
}  // namespace estancia
