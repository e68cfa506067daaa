// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/label_words.hpp"
#include "estancia/query/ask.hpp"
#include "map_file/sample_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

TEST(Ask, RanksPlacesByProbability) {
  const Answers answers = ask(test::sampleMap(), "Umbrella");
  EXPECT_THAT(answers.labels, ElementsAre(3U));
  ASSERT_EQ(answers.places.size(), 3U);
  const PlaceAnswer& best = answers.places[0];
  EXPECT_EQ(best.node, 1);
  EXPECT_FLOAT_EQ(static_cast<float>(best.probability), 0.7F);
  EXPECT_EQ(best.rank, 1U);
  EXPECT_TRUE(best.inTop5);
  // mean over the 7 images: (2·0.1 + 3·0.7 + 2·0) / 7
  EXPECT_NEAR(best.lift, 0.7 / (2.3 / 7), 1e-6);
  EXPECT_EQ(answers.places[1].node, 0);
  EXPECT_EQ(answers.places[1].rank, 4U);
  EXPECT_EQ(answers.places[2].node, 3);
  EXPECT_EQ(answers.places[2].rank, 5U);
  EXPECT_EQ(ask(test::sampleMap(), "umbrella", 1).places.size(), 1U);

  TopologicalMap six{.vocabulary = Vocabulary({"a", "b", "c", "d", "e", "f"})};
  six.nodes = {test::nodeWith(0, 1, {0.1F, 0.2F, 0.2F, 0.2F, 0.2F, 0.2F})};
  EXPECT_EQ(ask(six, "a").places[0].rank, 6U);
  EXPECT_FALSE(ask(six, "a").places[0].inTop5);
  EXPECT_TRUE(ask(six, "f").places[0].inTop5);
}

TEST(Ask, AddsUpAllMatchingLabelsButNeverAboveOne) {
  TopologicalMap map{.vocabulary = Vocabulary({"wine bottle", "water bottle", "desk"})};
  map.nodes = {test::nodeWith(0, 1, {0.3F, 0.2F, 0.5F}), test::nodeWith(1, 1, {0.9F, 0.8F, 0.1F})};
  const Answers answers = ask(map, "bottles");
  EXPECT_THAT(answers.labels, ElementsAre(0U, 1U));
  EXPECT_EQ(answers.places[0].node, 1);
  EXPECT_DOUBLE_EQ(answers.places[0].probability, 1);
  EXPECT_NEAR(answers.places[1].probability, 0.5, 1e-6);
  EXPECT_EQ(answers.places[1].label, 0U);
  EXPECT_EQ(answers.places[1].rank, 2U);
}

TEST(Ask, SuggestsNearSpellingsAndRefusesAnEmptyMap) {
  TopologicalMap map = test::sampleMap();
  const test::Caught caught = test::caught([&] { ask(map, "umbrela"); });
  EXPECT_THAT(caught, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT(caught.message, testing::HasSubstr("\"umbrella\""));
  for (const char* unknown : {"xylophone", ""})
    EXPECT_THAT([&] { ask(map, unknown); }, FailsWith(ErrorCode::noAnswer)) << unknown;
  map.nodes.clear();
  EXPECT_THAT([&] { ask(map, "desk"); }, FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia
