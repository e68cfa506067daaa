// Rooms named image by image, in blocks and in areas: counts by hand.
// SPDX-License-Identifier: Apache-2.0
#include "words/room_answers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/stats/proportion.hpp"
#include "support/errors.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using testing::DoubleNear;
using testing::ElementsAre;

std::vector<Frame> framesIn(const std::vector<std::string>& rooms) {
  std::vector<Frame> frames;
  for (const std::string& room : rooms) {
    Frame& frame = frames.emplace_back();
    frame.name = std::to_string(frames.size());
    frame.room = room;
  }
  return frames;
}

/// Predictions of a living room and a kitchen, by name.
RoomPredictions livingRoomOrKitchen(const std::vector<float>& livingRoom, bool areListed) {
  RoomPredictions predictions{"names", {"living room", "kitchen"}, DescriptorMatrix(2)};
  predictions.areByName = true;
  predictions.areListed = areListed;
  for (const float p : livingRoom)
    predictions.probabilities.append(p < 0 ? std::vector<float>{0, 0} : std::vector<float>{p, 1 - p});
  return predictions;
}

TEST(RoomAnswers, BlocksAreOfOneRoomAndLeaveTheRest) {
  const ImageGroups groups = blocksOfRooms(framesIn({"a", "b", "a", "", "a", "b", "a", "a"}), 2);
  EXPECT_THAT(groups.rooms, ElementsAre("a", "a", "b"));
  EXPECT_THAT(groups.groupOf, ElementsAre(0, 2, 0, 3, 1, 2, 1, 3));
  EXPECT_TRUE(blocksOfRooms(framesIn({"a", "b"}), 2).rooms.empty());
}

TEST(RoomAnswers, AreasAreInTheRoomOfMostOfTheirImages) {
  const ImageGroups groups = groupsOfAreas(framesIn({"a", "b", "b", "", "a"}), {0, 0, 0, 2, -1});
  EXPECT_THAT(groups.rooms, ElementsAre("b", "", ""));
  EXPECT_THAT(groups.groupOf, ElementsAre(0, 0, 0, 2, 3));
}

TEST(RoomAnswers, BlocksAreNamedAboveTheSureProbability) {
  RoomPredictions predictions = livingRoomOrKitchen({0.9F, 0.8F, 0.3F, -1}, true);
  const ImageGroups groups{{0, 0, 1, 2}, {"living_room", "living_room", "kitchen"}};
  auto answers = nameBlocks(predictions, groups);
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_EQ(answers[0].images, 2U);
  EXPECT_EQ(answers[0].answer, "living room");
  EXPECT_TRUE(answers[0].isSure);
  EXPECT_EQ(answers[1].answer, "kitchen");
  EXPECT_NEAR(answers[1].probability, 0.7, 1e-6);
  EXPECT_EQ(answers[2].answer, "") << "no image has a prediction";
  EXPECT_FALSE(answers[2].isSure);
  predictions.rooms = {"living room", "kitchen", "attic", "cellar"};
  predictions.probabilities = DescriptorMatrix(4);
  predictions.probabilities.append(std::vector<float>{0.3F, 0.3F, 0.2F, 0.2F});
  EXPECT_FALSE(nameBlocks(predictions, {{0}, {"kitchen"}})[0].isSure);
}

TEST(RoomAnswers, AreasAreNamedAsThoseOfMaps) {
  RoomPredictions predictions{"names", {"a", "b", "c", "d"}, DescriptorMatrix(4)};
  predictions.areByName = true;
  predictions.probabilities.append(std::vector<float>{0.31F, 0.23F, 0.23F, 0.23F});
  predictions.probabilities.append(std::vector<float>{0.30F, 0.24F, 0.23F, 0.23F});
  const ImageGroups groups{{0, 1}, {"a", "a"}};
  for (const bool areListed : {true, false}) {
    predictions.areListed = areListed;
    const auto answers = nameAreaGroups(predictions, groups);
    ASSERT_EQ(answers.size(), 2U);
    EXPECT_EQ(answers[0].answer, "a");
    EXPECT_EQ(answers[0].isSure, areListed) << "a listed room has to be somewhere";
    EXPECT_FALSE(answers[1].isSure);
  }
}

TEST(RoomAnswers, AreCountedByRoomAndTogether) {
  const auto frames = framesIn({"living_room", "living_room", "kitchen", "", "kitchen", "kitchen"});
  const RoomPredictions predictions = livingRoomOrKitchen({0.9F, 0.2F, 0.4F, 0.9F, -1, 0.1F}, true);
  const std::vector<GroupAnswer> groups{{2, "living_room", "kitchen", 0.4, true},
                                        {2, "kitchen", "kitchen", 0.9, true},
                                        {1, "kitchen", "", 0, false},
                                        {1, "", "kitchen", 0.9, true}};
  const CellResults results = measureRoomAnswers(predictions, frames, groups);
  EXPECT_EQ(valueOf(results, "images", "(all)"), 5);
  EXPECT_THAT(*valueOf(results, "accuracy", "(all)"), DoubleNear(3.0 / 5, 1e-12)) << "\"_\" is a blank";
  EXPECT_LT(*valueOf(results, "accuracy_low", "(all)"), 0.6);
  EXPECT_GT(*valueOf(results, "accuracy_high", "(all)"), 0.6);
  EXPECT_EQ(valueOf(results, "chance", "(all)"), 3.0 / 5);
  EXPECT_EQ(valueOf(results, "images", "living_room"), 2);
  EXPECT_EQ(valueOf(results, "accuracy", "living_room"), 0.5);
  EXPECT_EQ(valueOf(results, "accuracy", "kitchen"), 2.0 / 3) << "no prediction is wrong";
  EXPECT_EQ(valueOf(results, "groups", "(all)"), 3) << "of known rooms";
  EXPECT_EQ(valueOf(results, "pooled_accuracy", "(all)"), 1.0 / 3);
  EXPECT_EQ(valueOf(results, "pooled_low", "(all)"), wilsonInterval(1.0 / 3, 3.0).first);
  EXPECT_EQ(valueOf(results, "pooled_high", "(all)"), wilsonInterval(1.0 / 3, 3.0).second);
  EXPECT_EQ(valueOf(results, "pooled_accuracy", "kitchen"), 0.5);
  EXPECT_EQ(valueOf(results, "sure", "(all)"), 2.0 / 3);
  EXPECT_EQ(valueOf(results, "sure_accuracy", "(all)"), 0.5);
}

TEST(RoomAnswers, NeedNoGroupsButKnownRooms) {
  const RoomPredictions predictions = livingRoomOrKitchen({0.9F}, true);
  EXPECT_FALSE(valueOf(measureRoomAnswers(predictions, framesIn({"kitchen"}), {}), "groups", "(all)"));
  EXPECT_THAT([&] { measureRoomAnswers(predictions, framesIn({""}), {}); },
              FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia::experiments
