// `mpirun estancia experiment` as a user runs it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <thread>

#include "support/errors.hpp"
#include "support/mpirun.hpp"
#include "support/support.hpp"

namespace estancia::test {
namespace {

namespace fs = std::filesystem;

/// A bumpy surface seen from the origin, unlike itself however it is turned.
std::vector<std::array<double, 3>> bumps() {
  std::vector<std::array<double, 3>> points;
  for (double x = -0.1; x <= 0.1; x += 0.005)
    for (double y = -0.08; y <= 0.08; y += 0.005) {
      const auto bump = [&](double cx, double cy, double width, double height) {
        return height * std::exp(-(std::pow(x - cx, 2) + std::pow(y - cy, 2)) / (2 * width * width));
      };
      points.push_back({x, y,
                        1 - bump(-0.04, 0.03, 0.02, 0.05) - bump(0.05, -0.02, 0.03, 0.04) -
                            bump(0.02, 0.05, 0.015, 0.03)});
    }
  return points;
}

/// The surface moved by (dx, dy, 0), before a wall.
std::string pcd(double dx, double dy, bool wall) {
  std::string rows;
  std::size_t count = 0;
  const auto add = [&](double x, double y, double z) {
    rows += fmt::format("{:.5f} {:.5f} {:.5f}\n", x, y, z);
    ++count;
  };
  for (const auto& [x, y, z] : bumps()) add(x + dx, y + dy, z);
  for (double x = -0.3; wall && x <= 0.3; x += 0.02)
    for (double y = -0.3; y <= 0.3; y += 0.02) add(x, y, 1.2);
  return fmt::format(
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {}\nHEIGHT 1\n"
      "POINTS {}\nDATA ascii\n{}",
      count, count, rows);
}

class Mpirun : public MpirunTest {
 protected:
  void SetUp() override {
    MpirunTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    writeFile(scratch_ / "model.pcd", pcd(0, 0, false));
    std::string rows = "scene,object,model,pose\n";
    for (int s = 0; s < 3; ++s) {
      const double dx = 0.05 * s, dy = -0.04 * s;
      writeFile(scratch_ / fmt::format("s{}.pcd", s), pcd(dx, dy, true));
      writeFile(scratch_ / fmt::format("s{}.txt", s),
                fmt::format("1 0 0 {} 0 1 0 {} 0 0 1 0 0 0 0 1", dx, dy));
      rows += fmt::format("s{0}.pcd,relief,model.pcd,s{0}.txt\n", s);
    }
    writeFile(scratch_ / "pairs.csv", rows);
    writeConfig("[0.0005]", "[1, 2, 3]");
  }

  void writeConfig(const std::string& noises, const std::string& seeds) {
    writeFile(config_,
              "type = \"recognition\"\npairs = \"pairs.csv\"\nscene_filters = [\"none\", \"voxel\"]\n"
              "sizes = [1200]\nnoises = " +
                  noises + "\nseeds = " + seeds + "\n");
  }

  using MpirunTest::start;
  /// Threads of a rank are one, as the cores are few.
  pid_t start(int ranks, const fs::path& out) const {
    return MpirunTest::start(ranks, {"experiment", "run", config_, "-o", out, "--threads", "1"});
  }
  static std::size_t filesIn(const fs::path& folder) {
    std::error_code none;
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(folder, none))
      count += entry.path().extension() == ".json";
    return count;
  }

  /// results.csv without the columns that hold seconds.
  static std::string timeless(const fs::path& csv) {
    std::stringstream lines(readFile(csv));
    std::vector<bool> kept;
    std::string text;
    for (std::string line; std::getline(lines, line);) {
      std::stringstream cells(line);
      std::size_t c = 0;
      for (std::string cell; std::getline(cells, cell, ','); ++c) {
        if (kept.size() <= c) kept.push_back(!cell.ends_with("seconds"));
        if (kept[c]) text += cell + ",";
      }
      text += "\n";
    }
    return text;
  }

  const std::string config_ = scratch_ / "r.toml";
};

/// The process of rank `rank` that `mpirun` started.
std::optional<pid_t> processOf(pid_t mpirun, const std::string& rank) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream stat(entry.path() / "stat"), environment(entry.path() / "environ", std::ios::binary);
    const std::string all((std::istreambuf_iterator<char>(stat)), {});
    const auto after = all.rfind(')');
    if (after == std::string::npos) continue;
    std::stringstream rest(all.substr(after + 1));
    char state = 0;
    pid_t parent = 0;
    if (!(rest >> state >> parent) || parent != mpirun) continue;
    const std::string variables((std::istreambuf_iterator<char>(environment)), {});
    if (variables.find("OMPI_COMM_WORLD_RANK=" + rank + '\0') != std::string::npos) return std::stoi(name);
  }
  return std::nullopt;
}

TEST_F(Mpirun, FindsWhatASingleProcessFinds) {
  const auto alone = run({"experiment", "run", config_, "-o", scratch_ / "alone"});
  ASSERT_EQ(alone.exitCode, 0) << alone.err;
  const auto together = finish(start(3, scratch_ / "together"));
  ASSERT_EQ(together.exitCode, 0) << together.err;
  const std::string csv = timeless(scratch_ / "alone/results.csv");
  EXPECT_THAT(csv,
              testing::StartsWith("model_filter,scene_filter,size,noise,keypoint,descriptor,pairs,verified,"
                                  "correct,false_positives,absent,failed,"));
  EXPECT_NE(csv.find("\nnone,none,all,0.0005,uniform,shot,9,9,9,0,0,0,"), std::string::npos)
      << "all are found";
  EXPECT_EQ(timeless(scratch_ / "together/results.csv"), csv);
  EXPECT_EQ(filesIn(scratch_ / "together/cells"), 2U * 3 * 3);
  EXPECT_TRUE(fs::exists(scratch_ / "together/report.html"));
  const std::string answer = alone.out.substr(0, alone.out.find('\n') + 1);
  EXPECT_THAT(together.out, testing::StartsWith(answer));
  EXPECT_EQ(together.out.find(answer, 1), std::string::npos) << "one of them speaks";
}

TEST_F(Mpirun, WhatIsWrongIsOneLineAndExitCodeTwo) {
  const auto expectOneLine = [&](ErrorCode code, const std::string& fact) {
    const auto result = finish(start(3, scratch_ / "out"));
    EXPECT_EQ(result.exitCode, 2);
    const auto first = result.err.find("error: ");
    ASSERT_NE(first, std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("error: ", first + 1), std::string::npos) << result.err;
    const std::string line = result.err.substr(first, result.err.find('\n', first) - first);
    EXPECT_NE(line.find(fact), std::string::npos) << line;
    EXPECT_TRUE(line.ends_with(fmt::format("[{}]", nameOf(code)))) << line;
    EXPECT_EQ(result.out, "");
  };
  writeFile(scratch_ / "s1.pcd", "no cloud");  // seen by whoever takes it
  expectOneLine(ErrorCode::malformedFile, "s1.pcd");
  writeFile(config_, "type = \"recognition\"\n");
  expectOneLine(ErrorCode::malformedFile, "pairs");
}

TEST_F(Mpirun, AKilledRankCostsOnlyWhatRan) {
  std::string seeds = "[1";
  for (int s = 2; s <= 15; ++s) seeds += fmt::format(", {}", s);
  writeConfig("[0.0005, 0.001]", seeds + "]");
  const fs::path out = scratch_ / "out";
  const pid_t child = start(3, out);
  int status = 0;
  while (filesIn(out / "cells") < 6 && waitpid(child, &status, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto rank = processOf(child, "1");
  ASSERT_TRUE(rank) << readFile(scratch_ / "err");
  kill(*rank, SIGKILL);
  EXPECT_NE(finish(child).exitCode, 0);
  const std::size_t kept = filesIn(out / "cells");
  ASSERT_GE(kept, 6U);
  ASSERT_LT(kept, 180U) << "it was killed too late";
  EXPECT_FALSE(fs::exists(out / "results.csv"));
  std::map<std::string, fs::file_time_type> before;
  for (const auto& cell : fs::directory_iterator(out / "cells"))
    if (cell.path().extension() == ".json") before[cell.path()] = cell.last_write_time();

  const auto again = finish(start(3, out));
  ASSERT_EQ(again.exitCode, 0) << again.err;
  EXPECT_EQ(filesIn(out / "cells"), 180U);
  for (const auto& [cell, time] : before) EXPECT_EQ(fs::last_write_time(cell), time) << "computed again";
  EXPECT_NE(readFile(out / "results.csv").find("\nnone,voxel,1200,0.001,uniform,shot,45,"),
            std::string::npos);
}

}  // namespace
}  // namespace estancia::test
