// Base64 of RFC 4648, section 10.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/base64.hpp"

#include <gtest/gtest.h>

namespace estancia {
namespace {

TEST(Base64, IsThatOfTheStandard) {
  EXPECT_EQ(toBase64(""), "");
  EXPECT_EQ(toBase64("f"), "Zg==");
  EXPECT_EQ(toBase64("foob"), "Zm9vYg==");
  EXPECT_EQ(toBase64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(fromBase64("Zm9vYmFy"), "foobar");
  EXPECT_EQ(fromBase64("Zm9vYg=="), std::string("foob\0\0", 6)) << "padding becomes zeros";
}

TEST(Base64, RefusesOtherText) {
  EXPECT_FALSE(fromBase64("Zm9v!mFy"));
  EXPECT_FALSE(fromBase64("Zm9vY"));
}

}  // namespace
}  // namespace estancia
