// SPDX-License-Identifier: Apache-2.0
#include "runner/grid.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <limits>
#include <set>

#include "estancia/core/error.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::errorOf;
using test::FailsWith;
using test::readFile;
using test::ScratchFolder;
using test::writeFile;
namespace fs = std::filesystem;

const GridColumns columns{{"model", "sequence"}, "k", {"variance", "right"}};

std::vector<Cell> cells(std::size_t count, const std::string& inputs = "a") {
  std::vector<Cell> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back({{std::to_string(i), "tour"}, inputs});
  return result;
}

/// What cell i finds: numbers that no short text holds.
CellResults found(std::size_t i) {
  const double value = 1.0 / (3.0 + static_cast<double>(i));
  return {{"variance", "7", value}, {"right", "", -value * 1e-12}, {"kept", "7", 1}};
}

class GridTest : public testing::Test {
 protected:
  /// Runs the cells in a new Grid; `computed` lists the cells that were not at hand.
  std::vector<CellResults> run(const std::vector<Cell>& wanted, int threads = 2) {
    computed.clear();
    Grid grid(folder, columns, threads);
    std::mutex mutex;
    auto results = grid.run(
        wanted,
        [&](std::size_t i) {
          const std::lock_guard lock(mutex);
          computed.insert(i);
          return found(i);
        },
        silent, "testing");
    grid.writeCsv();
    return results;
  }

  ScratchFolder scratch;
  fs::path folder = scratch / "out";
  Progress silent;
  std::set<std::size_t> computed;
};

TEST_F(GridTest, ComputesEveryCellOnceAndReadsBackTheSameNumbers) {
  const auto first = run(cells(20));
  EXPECT_EQ(computed.size(), 20U);
  const auto second = run(cells(20));
  EXPECT_TRUE(computed.empty());
  for (std::size_t i = 0; i < 20; ++i)
    for (const auto* results : {&first, &second}) {
      ASSERT_EQ((*results)[i].size(), 3U);
      EXPECT_EQ((*results)[i][0].measure, "variance");
      EXPECT_EQ((*results)[i][0].at, "7");
      EXPECT_EQ((*results)[i][0].value, found(i)[0].value);
      EXPECT_EQ((*results)[i][1].at, "");
      EXPECT_EQ((*results)[i][1].value, found(i)[1].value);
    }
}

TEST_F(GridTest, TheTableIsTheSameForAnyNumberOfThreads) {
  std::set<std::string> tables;
  for (const int threads : {1, 2, 7}) {
    fs::remove_all(folder);
    run(cells(30), threads);
    tables.insert(readFile(folder / "results.csv"));
  }
  ASSERT_EQ(tables.size(), 1U);
  EXPECT_THAT(*tables.begin(),
              testing::StartsWith("model,sequence,k,variance,right\n0,tour,7,0.3333333333333333,\n"
                                  "0,tour,,,-3.333333333333333e-13\n1,tour,7,"));
}

TEST_F(GridTest, GoesOnWhereItStopped) {
  Grid grid(folder, columns, 1);
  const auto stopAt4 = [](std::size_t i) {
    if (i == 4) throw Interrupted("");
    return found(i);
  };
  EXPECT_THAT([&] { grid.run(cells(6), stopAt4, silent, "testing"); },
              FailsWith(ErrorCode::interrupted, "4", "6"));
  EXPECT_FALSE(fs::exists(folder / "results.csv"));
  run(cells(6));
  EXPECT_EQ(computed, (std::set<std::size_t>{4, 5}));
}

TEST_F(GridTest, ChangedInputsAndOtherCoordinatesAreComputed) {
  run(cells(3));
  run(cells(3, "b"));
  EXPECT_EQ(computed.size(), 3U);
  run(cells(5));
  EXPECT_EQ(computed, (std::set<std::size_t>{3, 4}));
}

TEST_F(GridTest, DamagedCellsAreComputedAgain) {
  run(cells(1));
  const fs::path cell = fs::directory_iterator(folder / "cells")->path();
  const std::string whole = readFile(cell);
  for (const std::string& damaged :
       {std::string(), std::string("{"), whole.substr(0, whole.size() / 2), std::string("[1, 2]"),
        std::string(R"({"estancia_cell":2,"inputs":"a","results":[[1,2,3]]})"),
        std::string(R"({"estancia_cell":2,"inputs":"a","results":7})"),
        std::string(R"({"estancia_cell":1,"inputs":"a","results":[]})"),
        std::string(R"({"estancia_cell":2,"inputs":"b","results":[]})")}) {
    writeFile(cell, damaged);
    const auto results = run(cells(1));
    EXPECT_EQ(computed.size(), 1U) << damaged;
    EXPECT_EQ(results[0][0].value, found(0)[0].value);
    EXPECT_EQ(readFile(cell), whole);
  }
}

TEST_F(GridTest, TheFirstCellsFailureEndsTheRunAndKeepsTheOthers) {
  Grid grid(folder, columns, 3);
  std::atomic<int> calls{0};
  const auto failing = [&](std::size_t i) -> CellResults {
    ++calls;
    if (i >= 5) throw Error(ErrorCode::corruptFile, "cell " + std::to_string(i) + " is broken");
    return found(i);
  };
  EXPECT_EQ(errorOf([&] { grid.run(cells(500), failing, silent, "testing"); }), "cell 5 is broken");
  EXPECT_LT(calls, 50);
  run(cells(5));
  EXPECT_TRUE(computed.empty());
}

TEST_F(GridTest, RefusesWhatIsNoNumberOrNoCell) {
  Grid grid(folder, columns, 1);
  const auto infinite = [](std::size_t) {
    return CellResults{{"variance", "", std::numeric_limits<double>::infinity()}};
  };
  EXPECT_THAT([&] { grid.run(cells(1), infinite, silent, "testing"); },
              FailsWith(ErrorCode::invalidInput, "variance", "0, tour"));
  EXPECT_THROW(grid.run({{{"alone"}, "a"}}, found, silent, "testing"), Error);
}

TEST_F(GridTest, AFolderThatCannotBeMadeIsAnError) {
  writeFile(scratch / "file", "");
  Grid grid(scratch.path() / "file" / "out", columns, 1);
  EXPECT_THAT([&] { grid.run(cells(1), found, silent, "testing"); }, FailsWith(ErrorCode::fileUnwritable));
}

TEST_F(GridTest, AForeignTableIsNotReplaced) {
  writeFile(folder / "results.csv", "mine\n");
  Grid grid(folder, columns, 1);
  EXPECT_THAT([&] { grid.run(cells(1), found, silent, "testing"); },
              FailsWith(ErrorCode::fileExists, "results.csv"));
  EXPECT_EQ(readFile(folder / "results.csv"), "mine\n");
}

TEST_F(GridTest, TextsInTheTableStayOneCell) {
  Grid grid(folder, {{"model", "sequence"}, "cut", {"v"}}, 1);
  grid.run(
      {{{"a,\"b\"", "line\nbreak"}, "x"}},
      [](std::size_t) {
        return CellResults{{"v", "at,last", 1}};
      },
      silent, "testing");
  grid.writeCsv();
  EXPECT_EQ(readFile(folder / "results.csv"),
            "model,sequence,cut,v\n\"a,\"\"b\"\"\",\"line\nbreak\",\"at,last\",1\n");
}

TEST_F(GridTest, WithoutPointsHasARowACell) {
  Grid grid(folder, {{"model"}, "", {"v", "w"}}, 1);
  const auto compute = [](std::size_t i) {
    CellResults results{{"w", "", 2}};
    if (i == 0) results.push_back({"v", "", 1});
    return results;
  };
  grid.run({{{"a"}, "x"}, {{"b"}, "x"}}, compute, silent, "testing");
  grid.writeCsv();
  EXPECT_EQ(readFile(folder / "results.csv"), "model,v,w\na,1,2\nb,,2\n");
}

TEST_F(GridTest, RowsMayBePutTogetherAndColumnsStandInAnyOrder) {
  Grid grid(folder,
            {{"model", "sequence", "preset"}, "", {"v", "w"}, {"model", "w", "sequence", "v", "preset"}}, 1);
  grid.makeFolder();
  grid.add({"a", "tour", "wide"}, {{"v", "", 1}, {"w", "", 3}});
  grid.add({"a", "tour", "tight, very"}, {{"v", "", 2}});
  grid.writeCsv();
  EXPECT_EQ(readFile(folder / "results.csv"),
            "model,w,sequence,v,preset\na,3,tour,1,wide\na,,tour,2,\"tight, very\"\n");
  EXPECT_THAT([&] { grid.add({"a", "tour", "wide"}, {}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_TRUE(fs::is_empty(folder / "cells"));
}

TEST_F(GridTest, RefusesTwoCellsOfOneName) {
  Grid grid(folder, columns, 1);
  grid.run(cells(2), found, silent, "testing");
  EXPECT_THAT([&] { grid.run(cells(1, "b"), found, silent, "testing"); },
              FailsWith(ErrorCode::invalidInput, "model, sequence", "0, tour"));
}

}  // namespace
}  // namespace estancia::experiments
