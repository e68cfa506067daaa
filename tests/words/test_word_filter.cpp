// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_filter.hpp"

#include <gtest/gtest.h>

namespace estancia {
namespace {

TEST(WordFilter, HasTheBitsOfAnIndependentOne) {
  EXPECT_EQ(packWordFilter({"bedsit", "hoover", "kitchen", "nappy", "zumba"}), "pUM10R1VVw==")
      << "computed by a script of the same description in another language";
  EXPECT_EQ(packWordFilter({}), "");
}

}  // namespace
}  // namespace estancia
