// Places that are seen again from another side, and places that only look alike.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/mapper/view_memory.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/synthetic.hpp"

namespace estancia {
namespace {

constexpr std::size_t words = 8;

/// An image at an angle [degrees] in the plane of two words, a unit vector: two images differ by 1 − cos.
std::vector<float> lookingAt(double degrees) {
  std::vector<float> vector(words);
  vector[0] = static_cast<float>(std::cos(degrees * std::numbers::pi / 180));
  vector[1] = static_cast<float>(std::sin(degrees * std::numbers::pi / 180));
  return vector;
}

class Views : public testing::Test {
 protected:
  static MapperOptions with(std::size_t views) {
    MapperOptions options;
    options.views = views;
    return options;
  }
  PlaceView at(double degrees, int node, const std::optional<Pose>& pose = {}) {
    const std::size_t frame = next_++;
    return {frame, node, frame, pose, lookingAt(degrees), lookingAt(degrees)};
  }
  void see(double degrees, int node, const std::optional<Pose>& pose = {}) {
    memory_.keep(at(degrees, node, pose), thresholds_);
  }
  std::optional<Recognition> look(double degrees, int current, const std::optional<Pose>& pose = {}) {
    return memory_.recognize(at(degrees, -1, pose), current, thresholds_);
  }

  std::size_t next_ = 0;
  /// .5, .15 and .25 are 60, 32 and 41 degrees.
  Thresholds thresholds_{0.5, 0.2, 0.15, 0.15, 0.25};
  ViewMemory memory_{getDistance("cosine"), words, with(40)};
};

TEST_F(Views, ShowTheirPlaceAgain) {
  see(0, 0);
  see(180, 1);
  const auto found = look(10, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->node, 0);
  EXPECT_NEAR(found->distance, 1 - std::cos(10 * std::numbers::pi / 180), 1e-6);
  EXPECT_EQ(found->threshold, 0.15);
  EXPECT_FALSE(found->byPose);
  EXPECT_FALSE(look(50, 1)) << "not so near";
}

TEST_F(Views, TwoFromTwoSidesAreASequence) {
  see(0, 0);
  see(60, 0);
  see(200, 1);
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(look(-38 - 0.1 * i, 1)) << "one alone may be of something else";
  const auto found = look(98, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->node, 0);
  EXPECT_EQ(found->threshold, 0.25);
}

TEST_F(Views, TakenNearShowTheirPlaceUnlessWordsContradict) {
  see(0, 0, Pose::planar(0, 0, 0));
  see(0, 1, Pose::planar(5, 0, 0));
  const auto found = look(50, 1, Pose::planar(0.5, 0, 0.3));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->node, 0);
  EXPECT_TRUE(found->byPose);
  EXPECT_EQ(found->threshold, 0.5);
  EXPECT_FALSE(look(70, 1, Pose::planar(0.5, 0, 0.3)));
  EXPECT_FALSE(look(50, 1, Pose::planar(0.5, 0, 1.0))) << "it looks elsewhere";
  EXPECT_FALSE(look(50, 1, Pose::planar(0.8, 0, 0))) << "not so near";
}

TEST_F(Views, TakenElsewhereOnlyLookAlike) {
  see(0, 0, Pose::planar(0, 0, 0));
  see(180, 1, Pose::planar(2, 0, 0));
  EXPECT_FALSE(look(0, 1, Pose::planar(4, 0, 0)));
  EXPECT_TRUE(look(0, 1)) << "where that is not known";
  EXPECT_TRUE(memory_.isElsewhere(0, Pose::planar(4, 0, 0)));
  EXPECT_FALSE(memory_.isElsewhere(0, Pose::planar(1, 0, 3)));
  EXPECT_FALSE(memory_.isElsewhere(0, std::nullopt));
  EXPECT_FALSE(memory_.isElsewhere(7, Pose::planar(4, 0, 0))) << "nothing is known of it";
  EXPECT_TRUE(memory_.areApart(0, 1));
  see(180, 1);
  EXPECT_FALSE(memory_.areApart(0, 1));
}

/// Nodes of a drive through places, some of which look like earlier ones.
std::size_t nodesOf(const std::vector<std::optional<Pose>>& poses) {
  test::SyntheticPlaces places(8, 200, 0.7);
  Mapper mapper(200);
  std::size_t next = 0;
  for (const auto& image : places.drive({0, 1, 2, 3, 4, 5, 6, 7, 2, 5, 0}, 12))
    mapper.add(image, poses[next++]);
  mapper.finish();
  return mapper.nodes();
}

TEST(MapperWithPoses, TellsPlacesThatLookAlikeApart) {
  std::vector<std::optional<Pose>> none(132), onward, back, still(132, Pose{}), some;
  for (std::size_t i = 0; i < 132; ++i) onward.push_back(Pose::planar(0.25 * static_cast<double>(i), 0, 0));
  for (const double place : {0, 1, 2, 3, 4, 5, 6, 7, 2, 5, 0})
    for (int i = 0; i < 12; ++i) back.push_back(Pose::planar(3 * place + 0.05 * i, 0, 0));
  some = back;
  for (std::size_t i = 0; i < some.size(); i += 3) some[i].reset();
  EXPECT_EQ(nodesOf(none), 8U);
  EXPECT_EQ(nodesOf(onward), 11U) << "it never came back";
  EXPECT_EQ(nodesOf(back), 8U);
  EXPECT_EQ(nodesOf(some), 8U);
  EXPECT_EQ(nodesOf(still), 8U) << "poses that never move say nothing";
  EXPECT_EQ(nodesOf(std::vector<std::optional<Pose>>(132, Pose{std::nan(""), 0, 0, 0, 0, 0, 1})), 8U);
}

}  // namespace
}  // namespace estancia
