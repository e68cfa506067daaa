// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/similar_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace estancia {
namespace {

TEST(SimilarNames, DifferInCaseOrBlanksAtTheEnds) {
  EXPECT_TRUE(isSimilar("Kitchen", "kitchen"));
  EXPECT_TRUE(isSimilar(" kitchen\t", "kitchen"));
  EXPECT_FALSE(isSimilar("kitchen", "kitchen")) << "they are the same";
  EXPECT_FALSE(isSimilar("living room", "livingroom"));
  EXPECT_FALSE(isSimilar("", "kitchen"));
}

TEST(SimilarNames, AreToldTogether) {
  EXPECT_EQ(warningsOfSimilarRooms({"Kitchen", "bath", "kitchen", "kitchen "}).size(), 1U);
  EXPECT_TRUE(warningsOfSimilarRooms({"bath", "kitchen"}).empty());
}

}  // namespace
}  // namespace estancia
