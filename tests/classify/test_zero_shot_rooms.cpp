// Rooms without an example: from the rooms' names, by WordNet.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/zero_shot_rooms.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/words/room_words.hpp"
#include "support/errors.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::realWords;

const std::vector<std::string> labels = {"stove",   "toaster", "four-poster", "pillow",
                                         "bathtub", "towel",   "zebra"};
const std::vector<std::string> rooms = {"kitchen", "bedroom", "bathroom"};

/// Images of which each shows one label, .7 of it.
DescriptorMatrix imagesOf(const std::vector<std::size_t>& shown) {
  DescriptorMatrix images(labels.size());
  for (const std::size_t label : shown) {
    std::vector<float> row(labels.size(), 0.001F);
    row[label] = 0.7F;
    images.append(row);
  }
  return images;
}

RoomPredictions predictionsOf(const std::vector<std::vector<float>>& rows) {
  RoomPredictions predictions{"test", rooms, DescriptorMatrix(rooms.size())};
  for (const std::vector<float>& row : rows) predictions.probabilities.append(row);
  return predictions;
}

std::vector<std::string> bestRooms(const RoomPredictions& predictions) {
  std::vector<std::string> best;
  for (std::size_t i = 0; i < predictions.probabilities.size(); ++i)
    best.push_back(rankedRooms(predictions, i).front().room);
  return best;
}

RoomPredictions predicted(const DescriptorMatrix& images, const std::vector<std::string>& listed) {
  return predictRoomsByNames(realWords(), Vocabulary(labels), images, listed);
}

TEST(ZeroShotRooms, FollowFromWhatLabelsHaveToDoWithTheirNamesOrThoseOfCommonOnes) {
  const RoomPredictions predictions = predicted(imagesOf({0, 1, 2, 3, 4, 5}), rooms);
  EXPECT_THAT(bestRooms(predictions),
              testing::ElementsAre("kitchen", "kitchen", "bedroom", "bedroom", "bathroom", "bathroom"));
  for (std::size_t i = 0; i < 6; ++i) {
    const DescriptorView row = predictions.probabilities.row(i);
    EXPECT_NEAR(std::accumulate(row.begin(), row.end(), 0.0), 1, 1e-5);
  }
  EXPECT_TRUE(predictions.areByName);
  EXPECT_TRUE(predictions.areListed);
  const RoomPredictions common = predicted(imagesOf({0, 0, 3, 4}), {});
  EXPECT_EQ(common.rooms, commonRooms());
  EXPECT_FALSE(common.areListed);
  EXPECT_THAT(bestRooms(common), testing::ElementsAre("kitchen", "kitchen", "bedroom", "bathroom"));
}

TEST(ZeroShotRooms, NeedRoomsThatHaveEnglishNames) {
  const DescriptorMatrix images = imagesOf({0});
  EXPECT_TRUE(knowsRooms(realWords(), {"kitchen", "living_room"}));
  EXPECT_FALSE(knowsRooms(realWords(), {"kitchen", "xyzzy"}));
  EXPECT_THAT([&] { predicted(images, {"kitchen", "xyzzy"}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { predicted(images, {"kitchen", ""}); }, FailsWith(ErrorCode::unknownName));
  EXPECT_THAT([&] { predicted(images, {"kitchen"}); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { predictRoomsByNames(realWords(), Vocabulary({"stove"}), images, rooms); },
              FailsWith(ErrorCode::mismatch));
}

TEST(RoomWords, ListsOfRoomsAreReadAsPeopleWriteThem) {
  EXPECT_THAT(listedRooms({"kitchen", " living room", "Kitchens", "Bath\t"}),
              testing::ElementsAre("kitchen", "living room", "Bath"));
  EXPECT_TRUE(listedRooms({}).empty());
  for (const char* wrong : {"", "  ", "---", "kit\x1B[31mchen", "\xFF"})
    EXPECT_THAT([&] { listedRooms({"kitchen", wrong}); }, FailsWith(ErrorCode::invalidOption));
}

TEST(RoomWords, WeighLabelsByRoomsAndTheirFurnishings) {
  const auto weights = roomLabelWeights(realWords(), Vocabulary({"stove", "studio couch", "altar"}),
                                        {"kitchen", "Living_Rooms", "church"});
  EXPECT_GT(weights[0][0], 0);
  EXPECT_GT(weights[1][1], weights[0][1]) << "a sofa is a living room's";
  EXPECT_EQ(weights[0][2], 0);
  EXPECT_GT(weights[2][2], 0) << "a room that is not common is told by its name alone";
  EXPECT_EQ(findCommonRoom("living_rooms")->name, "living room");
  EXPECT_EQ(findCommonRoom("church"), nullptr);
  EXPECT_EQ(findCommonRoom("sitting room"), nullptr);
  EXPECT_EQ(findCommonRoom(realWords(), "sitting room")->name, "living room");
  for (const char* none : {"church", "chair", "room", "xyzzy", ""})
    EXPECT_EQ(findCommonRoom(realWords(), none), nullptr) << none;
}

TEST(NamesAsPrior, CountLessWithEachExampleAndAreOfTheSameImagesAndRooms) {
  for (const auto& [examples, share] : {std::pair{0, 1.0}, {10, 0.75}, {40, 0.0}, {1000, 0.0}})
    EXPECT_EQ(shareOfNames(examples), share) << examples;
  const RoomPredictions one = predictionsOf({{1, 0, 0}}), two = predictionsOf({{1, 0, 0}, {0, 1, 0}});
  EXPECT_THAT([&] { withNames(one, two, 0.5); }, FailsWith(ErrorCode::mismatch));
  RoomPredictions others = one;
  others.rooms.back() = "attic";
  EXPECT_THAT([&] { withNames(one, others, 0.5); }, FailsWith(ErrorCode::mismatch));
}

TEST(NamesAsPrior, DecideWhatExamplesLeaveOpen) {
  const RoomPredictions trained =
      predictionsOf({{0.4F, 0.4F, 0.2F}, {0.9F, 0.05F, 0.05F}, {0, 0, 0}, {0, 1, 0}});
  const RoomPredictions byNames =
      predictionsOf({{0.2F, 0.6F, 0.2F}, {0.3F, 0.4F, 0.3F}, {0.8F, 0.1F, 0.1F}, {1, 0, 0}});
  const RoomPredictions both = withNames(trained, byNames, 0.5);
  EXPECT_EQ(rankedRooms(both, 0).front().room, "bedroom") << "as probable by examples, more by name";
  EXPECT_EQ(rankedRooms(both, 1).front().room, "kitchen") << "the examples are sure";
  EXPECT_TRUE(rankedRooms(both, 2).empty()) << "nothing was predicted";
  EXPECT_EQ(rankedRooms(both, 3).front().room, "bedroom") << "half of the names' evidence";
  // 0.4 √0.2, 0.4 √0.6, 0.2 √0.2, divided by their sum
  EXPECT_NEAR(both.probabilities.row(0)[1], 0.3098 / (0.1789 + 0.3098 + 0.0894), 1e-3);
  const RoomPredictions alone = withNames(trained, byNames, 0);
  for (std::size_t r = 0; r < rooms.size(); ++r)
    EXPECT_NEAR(alone.probabilities.row(0)[r], trained.probabilities.row(0)[r], 1e-6);
}

}  // namespace
}  // namespace estancia
