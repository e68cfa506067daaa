// estancia generate: shell completion and man pages, made of the commands' declarations.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsSupersetOf;
using testing::Not;

/// What bash offers after `line`, whose last word is being typed.
std::vector<std::string> offered(const std::string& line) {
  const std::string script = "source <(" ESTANCIA_COMMAND " generate bash); COMP_WORDS=(" + line +
                             "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _estancia; "
                             "printf '%s\\n' \"${COMPREPLY[@]}\"";
  const auto result = runProgram("bash", {"-c", script});
  EXPECT_EQ(result.exitCode, 0) << result.err;
  std::vector<std::string> words;
  std::istringstream lines(result.out);
  for (std::string word; std::getline(lines, word);)
    if (!word.empty()) words.push_back(word);
  return words;
}

TEST(Generate, BashOffersCommandsOptionsAndValues) {
  EXPECT_THAT(offered("estancia ro"), ElementsAre("route"));
  EXPECT_THAT(offered("estancia zones ''"), IsSupersetOf({"find"}));
  EXPECT_THAT(offered("estancia zones find --li"), ElementsAre("--linkage"));
  EXPECT_THAT(offered("estancia zones find --linkage c"), ElementsAre("complete"));
  EXPECT_THAT(offered("estancia export home.estancia --format ''"),
              ElementsAre("graphml", "json", "nav2", "rooms", "spark-dsg"));
  EXPECT_THAT(offered("estancia export home.estancia --max-words ''"), Not(Contains("graphml")));
}

TEST(Generate, ManPagesNameWhatTheCommandHas) {
  const ScratchFolder scratch;
  const std::string folder = scratch / "man";
  ASSERT_EQ(run({"generate", "man", "-o", folder}).exitCode, 0);
  const std::string page = readFile(folder + "/estancia-zones-find.1");
  EXPECT_THAT(page, testing::StartsWith(".TH estancia\\-zones\\-find 1"));
  EXPECT_THAT(page, testing::ContainsRegex("\\.B \\\\-\\\\-linkage NAME"));
  EXPECT_THAT(run({"generate", "man", "-o", folder}), FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(run({"generate", "man", "-o", folder, "--overwrite"}).exitCode, 0);
}

}  // namespace
}  // namespace estancia::test
