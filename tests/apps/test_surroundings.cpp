// The command in other people's surroundings: languages, users, file systems, closed streams, names in no
// encoding. SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "estancia/map_file/map.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/model_support.hpp"
#include "support/sample_home.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;

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
