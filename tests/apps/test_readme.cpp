// What the README shows is what compiles.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/support.hpp"

namespace estancia::test {
namespace {

TEST(Readme, ShowsAnExampleThatCompiles) {
  const std::filesystem::path root = ESTANCIA_SOURCE_DIR;
  const std::string readme = readFile(root / "README.md");
  const std::string open = "```cpp\n";
  const auto begin = readme.find(open);
  ASSERT_NE(begin, std::string::npos);
  const std::string shown =
      readme.substr(begin + open.size(), readme.find("```", begin + open.size()) - begin - open.size());
  EXPECT_GT(shown.size(), 200U);
  EXPECT_NE(readFile(root / "examples/12_ask_for_a_mug.cpp").find(shown), std::string::npos) << shown;
}

}  // namespace
}  // namespace estancia::test
