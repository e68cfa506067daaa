// Disks that fail and power that is cut: fakes/faulty_disk.cpp stands between the command and the disk.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <thread>

#include "estancia/map_file/map.hpp"
#include "support/color_model.hpp"
#include "support/errors.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;

class FaultyDisk : public testing::Test {
 protected:
  void SetUp() override {
    for (const fs::path& folder : {disk_, synced_}) fs::create_directory(folder);
  }

  /// Labels of a drive through two rooms, a hundred frames each.
  void writeLabels(int frames) const {
    std::string lines = "image,mug,desk,tree\n";
    for (int i = 0; i < frames; ++i)
      lines += fmt::format("{:06}.png,{},0.05\n", i, i / 100 % 2 == 0 ? "0.9,0.05" : "0.05,0.9");
    writeFile(labels_, lines);
  }

  /// Red and blue ones, ten a second, and the network that distinguishes them.
  void writeImages(int frames) const {
    fs::create_directory(scratch_ / "images");
    for (int i = 0; i < frames; ++i)
      cv::imwrite(scratch_ / "images" / fmt::format("{:06}.png", i),
                  cv::Mat(16, 16, CV_8UC3, i / 100 % 2 == 0 ? cv::Scalar(0, 0, 255) : cv::Scalar(255, 0, 0)));
    writeColorModel(scratch_ / "model");
  }

  std::vector<std::string> settings(const std::string& fault) const {
    return {"LD_PRELOAD=" ESTANCIA_FAULTY_DISK, "ESTANCIA_DISK=" + disk_.string(),
            "ESTANCIA_DISK_SYNCED=" + synced_.string(), "ESTANCIA_DISK_FAULT=" + fault};
  }

  CommandResult run(const std::string& fault, const std::vector<std::string>& arguments) const {
    std::vector<std::string> all = settings(fault);
    all.emplace_back(ESTANCIA_COMMAND);
    all.insert(all.end(), arguments.begin(), arguments.end());
    return runProgram("/usr/bin/env", all);
  }

  /// A process of its own, whose output is discarded.
  pid_t start(const std::vector<std::string>& arguments) const {
    std::vector<const char*> words{"estancia"};
    for (const std::string& argument : arguments) words.push_back(argument.c_str());
    words.push_back(nullptr);
    const pid_t child = fork();
    if (child != 0) return child;
    for (const std::string& setting : settings("")) putenv(strdup(setting.c_str()));
    const int nowhere = open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) dup2(nowhere, stream);
    execv(ESTANCIA_COMMAND, const_cast<char* const*>(words.data()));
    _exit(127);
  }

  std::vector<std::string> filesOnDisk() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(disk_)) names.push_back(entry.path().filename());
    return names;
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder scratch_;
  const fs::path disk_ = scratch_ / "disk", synced_ = scratch_ / "synced", labels_ = scratch_ / "labels.csv";
};

/// By SQLite alone: a MapStore would tidy up when it is closed, and sync what the writer has not.
std::size_t framesOf(const fs::path& map) {
  sqlite3* database = nullptr;
  sqlite3_stmt* count = nullptr;
  std::size_t frames = 0;
  if (sqlite3_open_v2(map.c_str(), &database, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK &&
      sqlite3_prepare_v2(database, "SELECT count(*) FROM frames", -1, &count, nullptr) == SQLITE_OK &&
      sqlite3_step(count) == SQLITE_ROW)
    frames = static_cast<std::size_t>(sqlite3_column_int64(count, 0));
  sqlite3_finalize(count);
  sqlite3_close(database);
  return frames;
}

TEST_F(FaultyDisk, FailsWithAnErrorAndLeavesNothingHalfWritten) {
  writeLabels(200);
  const fs::path map = scratch_ / "whole.estancia";
  ASSERT_EQ(test::run({"map", labels_, "-o", map}).exitCode, 0);
  const std::vector<std::pair<std::string, std::vector<std::string>>> commands{
      {"a.estancia", {"map", labels_, "-o", disk_ / "a.estancia"}},
      {"a.labels", {"label", labels_, "-o", disk_ / "a.labels"}},
      {"a.zones", {"zones", "find", labels_, "-o", disk_ / "a.zones"}},
      {"a.html", {"report", map, "-o", disk_ / "a.html"}}};
  for (const auto& [output, arguments] : commands)
    for (const std::string operation : {"open", "write", "sync", "rename"}) {
      int failed = 0;
      for (int call = 1; call <= 64; call *= 4) {
        SCOPED_TRACE(fmt::format("{}, {} {}", output, operation, call));
        const CommandResult result = run(fmt::format("{}:{}", operation, call), arguments);
        EXPECT_LE(result.exitCode, 2) << result.err;
        if (result.exitCode == 0) {
          EXPECT_EQ(filesOnDisk(), std::vector<std::string>{output});
          fs::remove(disk_ / output);
          break;
        }
        ++failed;
        EXPECT_THAT(caught(result).code,
                    testing::AnyOf(ErrorCode::fileUnwritable, ErrorCode::fileUnreadable));
        if (output.ends_with(".estancia") && fs::exists(disk_ / output)) {
          EXPECT_NO_THROW(readMap(disk_ / output)) << "what was committed before";
          fs::remove(disk_ / output);
        }
        EXPECT_THAT(filesOnDisk(), testing::IsEmpty());
        for (const std::string& file : filesOnDisk()) fs::remove(disk_ / file);
      }
      EXPECT_GT(failed, 0) << output << ": " << operation << " was never called";
    }
}

/// Large commits make SQLite tidy up and sync; small ones, of a camera, leave it to the commit itself.
TEST_F(FaultyDisk, APowerCutCostsNoMoreThanTheLastCommit) {
  writeLabels(400'000);
  writeImages(400);
  const fs::path map = disk_ / "a.estancia", left = synced_ / "a.estancia";
  const std::vector<std::vector<std::string>> commands{
      {"map", labels_, "-o", map},
      // plays at the recorded speed
      {"live", scratch_ / "images", "-o", map, "--model", scratch_ / "model", "--no-page"}};
  for (const auto& arguments : commands) {
    SCOPED_TRACE(arguments[0]);
    const pid_t child = start(arguments);
    // Four commits are seen, then the power is cut.
    std::vector<std::size_t> commits{0};
    while (commits.size() < 5 && waitpid(child, nullptr, WNOHANG) == 0) {
      if (const std::size_t frames = framesOf(map); frames > commits.back()) commits.push_back(frames);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    ASSERT_EQ(commits.size(), 5U) << "the drive was too short";
    if (!fs::exists(left))  // it was renamed when it had been synced, and not written since
      for (const auto& entry : fs::directory_iterator(synced_))
        if (entry.path().extension() == ".part") fs::rename(entry.path(), left);
    EXPECT_GE(framesOf(left), commits[3]);
    EXPECT_NO_THROW(readMap(left));
    for (const fs::path& folder : {disk_, synced_})
      for (const auto& entry : fs::directory_iterator(folder)) fs::remove(entry.path());
  }
}

}  // namespace
}  // namespace estancia::test
