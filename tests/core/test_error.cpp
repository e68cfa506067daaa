// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/core/printable.hpp"

namespace estancia {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

TEST(ErrorMessage, ShowsControlCharactersOfFilesAsTheirBytes) {
  const Error error(ErrorCode::malformedFile, "a.toml:1: \"\x1b[31m\" and \u202E and \xff\n");
  EXPECT_STREQ(error.what(), "a.toml:1: \"\\x1B[31m\" and \\xE2\\x80\\xAE and \\xFF\\x0A");
  EXPECT_EQ(error.code(), ErrorCode::malformedFile);
}

TEST(ErrorMessage, LeavesOutTheMiddleOfWhatIsTooLong) {
  std::string quoted;
  for (int i = 0; i < 20'000; ++i) quoted += "é";
  const std::string text =
      Error(ErrorCode::malformedFile, "a.pcd: \"" + quoted + "\"; write it again").what();
  EXPECT_LE(text.size(), 2000U);
  EXPECT_THAT(text, StartsWith("a.pcd: \"éé"));
  EXPECT_THAT(text, HasSubstr("é … é"));
  EXPECT_THAT(text, EndsWith("é\"; write it again"));
  EXPECT_EQ(printable(text), text) << "no letter is cut";
}

}  // namespace
}  // namespace estancia
