// SPDX-License-Identifier: Apache-2.0
#include "places/place_recognition.hpp"

#include <gtest/gtest.h>

#include <random>

#include "estancia/stats/label_scale.hpp"
#include "places/posed_descriptors.hpp"
#include "support/synthetic.hpp"

namespace estancia::experiments {
namespace {

/// Images along a line: what they look like is one number, where they are is another.
struct Drive {
  explicit Drive(const std::vector<std::pair<float, double>>& images) {
    for (const auto& [look, place] : images) {
      vectors.append(std::vector<float>{look});
      positions.push_back({place, 0, 0});
      frames.push_back(frames.size());
    }
  }
  PlacedImages placed() const { return {vectors, positions, frames}; }

  DescriptorMatrix vectors{1};
  std::vector<Position> positions;
  std::vector<std::size_t> frames;
};

TEST(PlaceRecognition, CountsWhoseNearestImageIsNear) {
  const Drive map({{0, 0}, {1, 10}, {2, 20}, {3, 30}});
  const Drive again({{0.1F, 0.5}, {2.9F, 10}, {2.2F, 19}, {3, 500}});  // right, wrong, right, nowhere
  const auto found = recognizePlaces(again.placed(), map.placed(), Comparison::euclidean, 1, 0);
  EXPECT_EQ(found.queries, 3U);
  EXPECT_DOUBLE_EQ(found.right, 2.0 / 3);
  EXPECT_DOUBLE_EQ(found.chance, 0.25);
}

TEST(PlaceRecognition, OfASingleDriveLeavesNeighborsInTimeOut) {
  // To the end of a corridor and back; every image looks most like the one before it.
  const Drive drive({{0, 0}, {1, 1}, {2, 2}, {2.1F, 2}, {1.1F, 1}, {0.1F, 0}});
  const auto all = recognizePlaces(drive.placed(), drive.placed(), Comparison::euclidean, 0.1, 1);
  EXPECT_EQ(all.queries, 4U) << "the two in the middle have each other only, one frame away";
  EXPECT_DOUBLE_EQ(all.right, 1);
  const auto none = recognizePlaces(drive.placed(), drive.placed(), Comparison::euclidean, 0.1, 5);
  EXPECT_EQ(none.queries, 0U);
  EXPECT_EQ(none.right, 0);
}

TEST(PlaceRecognition, CountsFramesNotImages) {
  Drive drive({{0, 0}, {1, 5}, {0, 0}});
  drive.frames = {0, 100, 200};  // frames between have no pose
  EXPECT_EQ(recognizePlaces(drive.placed(), drive.placed(), Comparison::euclidean, 1, 150).queries, 2U);
}

TEST(PlaceRecognition, AgreesWithALiteralTranscription) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform;
  Drive drive({});
  for (std::size_t i = 0; i < 80; ++i) {
    drive.vectors.append(std::vector<float>{uniform(random)});
    drive.positions.push_back({8 * uniform(random), 3 * uniform(random), uniform(random)});
    drive.frames.push_back(2 * i);
  }
  const double radius = 1.1;
  const std::size_t gap = 9;
  double queries = 0, right = 0;
  for (std::size_t q = 0; q < 80; ++q) {
    std::vector<std::pair<float, bool>> answers;
    for (std::size_t i = 0; i < 80; ++i) {
      const auto apart = std::abs(static_cast<int>(drive.frames[q]) - static_cast<int>(drive.frames[i]));
      double squares = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        squares += std::pow(drive.positions[q][axis] - drive.positions[i][axis], 2);
      if (apart > static_cast<int>(gap))
        answers.emplace_back(std::abs(drive.vectors.row(q)[0] - drive.vectors.row(i)[0]),
                             squares <= radius * radius);
    }
    if (std::none_of(answers.begin(), answers.end(), [](auto& a) { return a.second; })) continue;
    ++queries;
    right += std::min_element(answers.begin(), answers.end())->second ? 1 : 0;
  }
  const auto found = recognizePlaces(drive.placed(), drive.placed(), Comparison::euclidean, radius, gap);
  EXPECT_EQ(static_cast<double>(found.queries), queries);
  EXPECT_DOUBLE_EQ(found.right, right / queries);
}

TEST(ComparedVectors, StandardizedOnesTellMadeUpPlacesApart) {
  test::SyntheticPlaces places(6, 50);
  DescriptorMatrix first(50), second(50);
  std::vector<Position> positions;
  std::vector<std::size_t> frames;
  for (std::size_t p = 0; p < 6; ++p)
    for (std::size_t i = 0; i < 8; ++i) {
      first.append(places.image(p));
      second.append(places.image(p));
      positions.push_back({static_cast<double>(p), 0, 0});
      frames.push_back(frames.size());
    }
  for (const char* name : {"standardized-clr", "clr-cosine", "hellinger"}) {
    const Distance distance = getDistance(name);
    const DescriptorMatrix map = comparedVectors(first, first, distance),
                           queries = comparedVectors(second, first, distance);
    const auto found =
        recognizePlaces({queries, positions, frames}, {map, positions, frames}, distance.comparison, 0.5, 0);
    EXPECT_EQ(found.queries, 48U);
    EXPECT_GT(found.right, 0.95) << name;
    EXPECT_NEAR(found.chance, 1.0 / 6, 1e-12);
  }
}

}  // namespace
}  // namespace estancia::experiments
