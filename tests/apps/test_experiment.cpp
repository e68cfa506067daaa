// `estancia experiment`: the command becomes the laboratory where that is installed.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;

class Laboratory : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* folder : {"bin", "libexec/estancia", "path"}) fs::create_directories(scratch_ / folder);
    fs::copy_file(ESTANCIA_COMMAND, scratch_ / "bin/estancia");
  }

  /// Runs a command that finds no other laboratory than those of the test.
  CommandResult experiment(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"PATH=" + (scratch_ / "path").string(),
                                         (scratch_ / "bin/estancia").string(), "experiment"});
    return runProgram("/usr/bin/env", arguments);
  }

  /// A laboratory that prints its name and its arguments.
  void writeLaboratory(const std::string& folder) const {
    const fs::path file = scratch_ / (folder + "/estancia-lab");
    writeFile(file, "#!/bin/sh\nprintf '%s\\n' " + folder + " \"$@\"\necho warning >&2\nexit 7\n");
    fs::permissions(file, fs::perms::owner_all);
  }

  ScratchFolder scratch_;
};

TEST_F(Laboratory, ThatIsMissingIsOneLineWithThePackage) {
  const auto refused = experiment({"run", "choice.toml", "-o", "out"});
  EXPECT_THAT(refused, FailsWith(ErrorCode::missingDependency, "estancia-lab"));
  EXPECT_EQ(refused.out, "");
  const auto json = nlohmann::json::parse(experiment({"run", "choice.toml", "--json"}).out);
  EXPECT_EQ(json["error"]["code"], "missing-dependency");
  EXPECT_THAT(experiment({}), FailsWith(ErrorCode::missingDependency, "estancia-lab"));
  const auto help = experiment({"--help"});
  EXPECT_EQ(help.exitCode, 0) << help.err;
  EXPECT_THAT(help.out, testing::HasSubstr("estancia-lab"));
}

TEST_F(Laboratory, GetsTheArgumentsAndGivesTheExitCode) {
  for (const std::string folder : {"path", "libexec/estancia", "bin"}) {  // whose turn is later, comes first
    writeLaboratory(folder);
    const auto result = experiment({"run", "a b.toml", "--json", "--help"});
    EXPECT_EQ(result.exitCode, 7);
    EXPECT_EQ(result.out, folder + "\nrun\na b.toml\n--json\n--help\n");
    EXPECT_EQ(result.err, "warning\n");
  }
}

}  // namespace
}  // namespace estancia::test
