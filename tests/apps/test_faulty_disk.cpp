// What surrounds the command: languages, limits, failing disks and cut power (fakes/faulty_disk.cpp).
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "estancia/map_file/map.hpp"
#include "support/color_model.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/model_support.hpp"
#include "support/sample_home.hpp"

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

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

class Surroundings : public testing::Test {
 protected:
  void SetUp() override {
    std::string lines = "image,mug,desk,tree\n";
    for (int i = 0; i < 40; ++i)
      lines += fmt::format("i{}.png,{},0.05\n", i, i / 10 % 2 == 0 ? "0.9,0.05" : "0.05,0.9");
    writeFile(labels_, lines);
  }

  /// Runs `estancia arguments…` by a line of the shell, in which "$@" is the command.
  CommandResult runBy(const std::string& line, const std::vector<std::string>& arguments) const {
    std::vector<std::string> words{"-c", line, "sh", ESTANCIA_COMMAND};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return runProgram("/bin/sh", words);
  }
  /// Runs as another user if the test runs as root: what the mode of a file forbids is forbidden.
  CommandResult runUnprivileged(const std::string& line, const std::vector<std::string>& arguments) const {
    return runBy(
        geteuid() == 0 ? "exec setpriv --bounding-set=-all /bin/sh -c '" + line + "' sh \"$@\"" : line,
        arguments);
  }
  fs::path mapped(const std::string& name) const {
    const CommandResult result = run({"map", labels_, "-o", folder_ / name});
    EXPECT_EQ(result.exitCode, 0) << result.err;
    return folder_ / name;
  }

  const WithoutWordNet names_;  // which would be read by each command
  ScratchFolder folder_;
  const fs::path labels_ = folder_ / "labels.csv";
};

/// Everything that reads or writes decimals, once.
std::string resultsIn(const fs::path& folder, const std::vector<std::string>& environment) {
  const fs::path home = folder / "home", model = folder / "model", map = folder / "a.estancia";
  fs::create_directories(folder);
  writeSampleHome(home);
  writeSmallModel(model);
  std::string all;
  const auto command = [&](const std::vector<std::string>& arguments, bool tells = true) {
    std::vector<std::string> words = environment;
    words.emplace_back(ESTANCIA_COMMAND);
    words.insert(words.end(), arguments.begin(), arguments.end());
    const CommandResult result = runProgram("/usr/bin/env", words);
    all += fmt::format("{}: {}\n{}\n", arguments[0], result.exitCode, tells ? result.out : "");
  };
  command({"check", home});
  command({"label", home, "--model", model, "-o", folder / "labels.csv"}, false);
  command({"map", home, "--model", model, "-o", map}, false);
  for (const char* format : {"json", "graphml", "nav2", "spark-dsg"})
    command({"export", map, "--format", format});
  command({"ask", map, "word 1", "--json"});
  command({"ask", map, "Word 1"});
  command({"route", map, "--from", "0", "--to", "word 1", "--json"});
  command({"zones", "find", map, "-o", folder / "a.zones"}, false);
  command({"export", folder / "a.zones", "--format", "rooms"});
  command({"report", map, "-o", folder / "a.html"}, false);
  command({"evaluate", map, home, "--json"});
  command({"options", "map"});
  for (const char* file : {"labels.csv", "a.zones", "a.html"}) all += readFile(folder / file);
  return replaced(std::move(all), folder.string(), "");
}

/// Turkish has commas in decimals as German has, and an i of its own.
TEST_F(Surroundings, NoLanguageChangesNumbersOrNames) {
  const std::string known = resultsIn(folder_ / "C", {}), language = "tr_TR";
  ASSERT_NE(known.find("0.5"), std::string::npos);
  const fs::path locales = folder_ / "locales";
  fs::create_directories(locales);
  ASSERT_EQ(runProgram("/usr/bin/localedef",
                       {"-i", language, "-f", "UTF-8", "--no-archive", locales / (language + ".UTF-8")})
                .exitCode,
            0)
      << "install the package locales";
  const std::vector<std::string> environment{"LD_PRELOAD=" ESTANCIA_FOREIGN_LOCALE,
                                             "LOCPATH=" + locales.string(), "LC_ALL=" + language + ".UTF-8"};
  EXPECT_EQ(resultsIn(folder_ / language, environment), known);
}

TEST_F(Surroundings, WhatMayNotBeReadOrWrittenIsToldSo) {
  const fs::path file = mapped("a.estancia"), closed = folder_ / "closed";
  fs::create_directory(closed);
  fs::copy_file(file, closed / "a.estancia");
  const std::string ask = "exec \"$@\"";
  fs::permissions(closed, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_EQ(runUnprivileged(ask, {"ask", closed / "a.estancia", "mug"}).exitCode, 0)
      << "a map is read in a folder that nobody may write";
  EXPECT_THAT(runUnprivileged(ask, {"map", labels_, "-o", closed / "b.estancia"}),
              FailsWith(ErrorCode::fileUnwritable));
  fs::permissions(closed, fs::perms::owner_all);
  fs::permissions(closed / "a.estancia", fs::perms::none);
  fs::permissions(labels_, fs::perms::none);
  EXPECT_THAT(runUnprivileged(ask, {"ask", closed / "a.estancia", "mug"}),
              FailsWith(ErrorCode::fileUnreadable));
  EXPECT_THAT(runUnprivileged(ask, {"map", labels_, "-o", folder_ / "b.estancia"}),
              FailsWith(ErrorCode::fileUnreadable));
}

TEST_F(Surroundings, NoHomeIsNeeded) {
  writeSmallModel(folder_ / "model");
  writeSampleHome(folder_ / "home");
  // Where there is none at all it is that of the list of users, where a cache would be left behind.
  EXPECT_EQ(runBy("exec env -u HOME -u ESTANCIA_CACHE \"$@\"", {"map", labels_, "-o", folder_ / "a.estancia"})
                .exitCode,
            0);
  for (const std::string home : {"/nowhere", "not/absolute"}) {
    const fs::path file = folder_ / ("b" + std::to_string(home.size()) + ".estancia");
    const CommandResult result =
        runUnprivileged("exec env -u ESTANCIA_CACHE -u XDG_CACHE_HOME HOME=" + home + " \"$@\"",
                        {"map", folder_ / "home", "--model", folder_ / "model", "-o", file});
    EXPECT_EQ(result.exitCode, 0) << home << result.err;
    EXPECT_EQ(readMap(file).frames.size(), 8U);
  }
}

TEST_F(Surroundings, FullDisksAreToldBeforeAndWhileAMapIsWritten) {
  const fs::path disk = folder_ / "disk";
  fs::create_directory(disk);
  for (const std::string size : {"32k", "80k"}) {  // 64 KiB are tried out first
    const std::string mount =
        fmt::format("exec unshare -m /bin/sh -c 'mount -t tmpfs -o size={} none {} && exec \"$@\"' sh \"$@\"",
                    size, disk.string());
    if (runBy(mount, {"--version"}).exitCode != 0) GTEST_SKIP() << "only root mounts file systems";
    EXPECT_THAT(runBy(mount, {"map", labels_, "-o", disk / "a.estancia"}),
                FailsWith(ErrorCode::fileUnwritable))
        << size;
  }
}

TEST_F(Surroundings, ClosedStreamsTakeNoFile) {
  const fs::path known = mapped("known.estancia");
  const std::string answer = run({"ask", known, "mug"}).out;
  ASSERT_NE(answer, "");
  int number = 0;
  for (const std::string closed : {">&-", "<&- >&- 2>&-"}) {
    const fs::path file = folder_ / fmt::format("{}.estancia", number++);
    runBy("exec \"$@\" " + closed, {"map", labels_, "-o", file});
    EXPECT_EQ(readMap(file).frames.size(), 40U) << closed;
    EXPECT_EQ(run({"ask", file, "mug"}).out, answer) << closed;
    const fs::path exported = folder_ / fmt::format("{}.json", number);
    runBy("exec \"$@\" " + closed, {"export", file, "--format", "json", "-o", exported});
    EXPECT_EQ(readFile(exported), run({"export", file, "--format", "json"}).out) << closed;
  }
  EXPECT_NE(runBy("exec \"$@\" >&-", {"ask", known, "mug"}).exitCode, 0) << "nobody has got the answer";
}

TEST_F(Surroundings, TenProcessesShareACacheAndOneMakesTheMap) {
  writeSmallModel(folder_ / "model");
  writeSampleHome(folder_ / "home");
  const std::string shared = fmt::format(
      "cd {} && export ESTANCIA_CACHE={}/cache; for i in 1 2 3 4 5 6 7 8 9 10; do (\"$@\" -o {{}} >out$i "
      "2>&1; "
      "echo $? >code$i) & done; wait; cat code*",
      folder_.path().string(), folder_.path().string());
  const auto codes = [&](const std::string& output, const std::vector<std::string>& arguments) {
    std::string text = runBy(replaced(shared, "{}", output), arguments).out;
    std::erase(text, '\n');
    std::ranges::sort(text);
    return text;
  };
  EXPECT_EQ(codes("$i.labels", {"label", folder_ / "home", "--model", folder_ / "model"}), "0000000000");
  for (int i = 2; i <= 10; ++i)
    EXPECT_EQ(readFile(folder_ / fmt::format("{}.labels", i)), readFile(folder_ / "1.labels"));
  EXPECT_EQ(codes("a.estancia", {"map", folder_ / "home", "--model", folder_ / "model"}), "0222222222");
  EXPECT_EQ(readMap(folder_ / "a.estancia").frames.size(), 8U);
}

}  // namespace
}  // namespace estancia::test
