// `estancia experiment` of the type scenes, as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>

#include "color_drive.hpp"
#include "support/errors.hpp"
#include "support/signaled_command.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class ScenesCommand : public testing::Test {
 protected:
  void SetUp() override {
    writeColorModel(scratch_, "blind", "1e-9");
    writeColorDrive(scratch_ / "one", 1);
    writeColorDrive(scratch_ / "two", 2);
  }

  void writeConfig(int seeds) const {
    std::string list;
    for (int seed = 1; seed <= seeds; ++seed) list += (seed > 1 ? ", " : "") + std::to_string(seed);
    writeFile(scratch_ / "study.toml",
              "type = \"scenes\"\nseeds = [" + list + "]\ndescriptors = [\"phog\", \"" +
                  (scratch_ / "blind").string() + "+phog\"]\nclassifiers = [\"forest\", \"svm-linear\"]\n" +
                  "[[data]]\nname = \"one\"\npath = \"one\"\n[[data]]\nname = \"two\"\npath = \"two\"\n");
  }
  std::vector<std::string> arguments(const std::string& out) const {
    return {"experiment", "run", scratch_ / "study.toml", "-o", scratch_ / out, "--threads", "1"};
  }

  /// Names and times of the finished cells.
  std::map<std::string, fs::file_time_type> cells(const std::string& out) const {
    std::map<std::string, fs::file_time_type> found;
    std::error_code none;
    for (const auto& file : fs::directory_iterator(scratch_ / out / "cells", none))
      if (file.path().extension() == ".json") found[file.path().filename()] = file.last_write_time();
    return found;
  }

  ScratchFolder scratch_;
};

TEST_F(ScenesCommand, PrintsTheTablesAndWritesTheStatistics) {
  writeConfig(1);
  const auto result = run(arguments("out"));
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_THAT(result.out, testing::StartsWith("study: right answers by the best of "));
  EXPECT_TRUE(fs::exists(scratch_ / "out/report.html"));
  for (const std::string file : {"study-statistics", "study-descriptors", "study-classifiers"}) {
    for (const std::string ending : {".md", ".html"})
      EXPECT_THAT(readFile(scratch_ / "out" / (file + ending)), HasSubstr("Friedman")) << file << ending;
    for (const std::string ending : {".svg", ".tex", ".csv"})
      EXPECT_GT(fs::file_size(scratch_ / "out" / (file + ending)), 20U) << file << ending;
  }
}

TEST_F(ScenesCommand, WhatTwoFilesAskForIsRefusedBeforeAnyOfItIsFound) {
  writeConfig(1);
  fs::copy_file(scratch_ / "study.toml", scratch_ / "again.toml");
  auto both = arguments("out");
  both.insert(both.begin() + 2, scratch_ / "again.toml");
  const auto result = run(both);
  EXPECT_THAT(result,
              FailsWith(ErrorCode::invalidInput, "again.toml", "study.toml", "phog, forest, one, one"));
  EXPECT_FALSE(fs::exists(scratch_ / "out"));
  writeFile(scratch_ / "file", "");
  const auto nowhere = run(arguments("file/out"));
  EXPECT_EQ(nowhere.exitCode, 2);
  EXPECT_EQ(nowhere.err.find("labeling"), std::string::npos) << "known before the long work";
}

TEST_F(ScenesCommand, ItsScoresCanBeComparedAnew) {
  writeConfig(1);
  ASSERT_EQ(run(arguments("out")).exitCode, 0);
  const auto result = run({"compare", scratch_ / "out/study-scores.csv", "--post-hoc", "nemenyi"});
  ASSERT_EQ(result.exitCode, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("phog/forest"));
}

TEST_F(ScenesCommand, AKilledRunGoesOnAndEndsInTheSameTable) {
  writeConfig(12);
  const int status = signalCommand(
      arguments("killed"), scratch_ / "cache", [&] { return cells("killed").size() >= 3; },
      std::chrono::milliseconds(0), SIGKILL);
  ASSERT_TRUE(WIFSIGNALED(status)) << "it had finished before it could be killed";
  const auto kept = cells("killed");
  ASSERT_GE(kept.size(), 3U);
  ASSERT_LT(kept.size(), 16U);
  EXPECT_FALSE(fs::exists(scratch_ / "killed/results.csv"));
  ASSERT_EQ(run(arguments("killed")).exitCode, 0);
  const auto all = cells("killed");
  EXPECT_EQ(all.size(), 16U);
  for (const auto& [name, time] : kept) EXPECT_EQ(all.at(name), time) << "not computed again";
  ASSERT_EQ(run(arguments("whole")).exitCode, 0);
  EXPECT_EQ(readFile(scratch_ / "killed/results.csv"), readFile(scratch_ / "whole/results.csv"));
}

}  // namespace
}  // namespace estancia::test
