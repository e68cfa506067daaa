// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/runner/work_queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <thread>

#include "estancia/core/error.hpp"
#include "experiments/src/runner/grid.hpp"
#include "local_ranks.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::LocalRanks;
using test::readFile;
using test::ScratchFolder;
namespace fs = std::filesystem;

/// Runs program(distribution, rank) in so many processes that are threads; what they throw.
std::vector<test::Caught> inProcesses(int count, const std::function<void(WorkQueue&, int)>& program) {
  auto ranks = LocalRanks::several(count);
  std::vector<test::Caught> errors(static_cast<std::size_t>(count));
  std::vector<std::thread> processes;
  for (int r = 0; r < count; ++r)
    processes.emplace_back([&, r] {
      const auto i = static_cast<std::size_t>(r);
      WorkQueue distribution(std::move(ranks[i]));
      errors[i] = test::caught([&] { distribution.together([&] { program(distribution, r); }); });
    });
  for (std::thread& process : processes) process.join();
  return errors;
}

void expectNone(const std::vector<test::Caught>& errors) {
  for (const test::Caught& error : errors) EXPECT_FALSE(error.code) << error;
}

void rest() {
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

std::vector<std::size_t> upTo(std::size_t count) {
  std::vector<std::size_t> pieces(count);
  for (std::size_t i = 0; i < count; ++i) pieces[i] = i;
  return pieces;
}

TEST(WorkQueue, EveryPieceIsDoneOnceByWhoeverIsFree) {
  for (const std::size_t threads : {1U, 3U}) {
    std::vector<std::atomic<int>> times(200);
    std::atomic<std::size_t> done = 0;
    std::atomic<int> byTheSlow = 0, byTheFirst = 0, told = 0, unfinished = 0;
    const auto errors = inProcesses(4, [&](WorkQueue& distribution, int rank) {
      distribution.each(
          "list", rank == 0 ? upTo(200) : upTo(7), threads,
          [&](std::size_t i) {
            ++times[i];
            if (rank == 0) ++byTheFirst;
            if (rank == 3) {
              ++byTheSlow;
              while (done < 200 - threads) rest();
            }
            ++done;
          },
          [&] { ++told; });
      for (const auto& count : times) unfinished += count == 0;
    });
    expectNone(errors);
    for (const auto& count : times) EXPECT_EQ(count, 1);
    EXPECT_EQ(unfinished, 0) << "nobody goes on before all is done";
    EXPECT_EQ(told, 200 - byTheFirst) << "of what others do";
    EXPECT_LE(byTheSlow, static_cast<int>(threads)) << "the others do what a slow one does not come to";
  }
}

TEST(WorkQueue, WorkFollowsWorkAndMayBeNone) {
  std::atomic<int> first = 0, second = 0;
  const auto errors = inProcesses(3, [&](WorkQueue& distribution, int) {
    distribution.each(
        "a", upTo(5), 2, [&](std::size_t) { ++first; }, [] {});
    distribution.each(
        "b", {}, 2, [&](std::size_t) { ++first; }, [] {});
    distribution.each(
        "c", {3, 8}, 2, [&](std::size_t i) { second += static_cast<int>(i); }, [] {});
    EXPECT_EQ(first, 5);
    EXPECT_EQ(second, 11);
  });
  expectNone(errors);
}

TEST(WorkQueue, ResultsOfAnyLengthComeToTheFirst) {
  const auto resultOf = [](std::size_t i) { return std::string(700 * i, '"') + std::to_string(i); };
  std::atomic<int> told = 0, byOthers = 0;
  const auto errors = inProcesses(3, [&](WorkQueue& distribution, int rank) {
    for (const std::size_t count : {12U, 5U}) {
      const std::vector<std::string> results = distribution.results(
          "list" + std::to_string(count), count,
          [&](std::size_t i) {
            if (rank != 0) ++byOthers;
            while (rank == 0 && count == 12 && byOthers == 0) rest();
            return resultOf(i);
          },
          [&] { ++told; });
      ASSERT_EQ(results.size(), rank == 0 ? count : 0);
      for (std::size_t i = 0; i < results.size(); ++i) EXPECT_EQ(results[i], resultOf(i));
    }
  });
  expectNone(errors);
  EXPECT_EQ(told, 17) << "of all pieces";
}

TEST(WorkQueue, AFailureAnywhereEndsAllAndIsToldByTheFirst) {
  for (const int failing : {0, 1, 2}) {
    std::atomic<bool> failed = false;
    std::atomic<int> done = 0;
    const auto errors = inProcesses(3, [&](WorkQueue& distribution, int rank) {
      distribution.each(
          "list", upTo(500), 2,
          [&](std::size_t i) {
            if (rank == failing) failed = true;
            if (rank == failing) throw Error(ErrorCode::corruptFile, "piece " + std::to_string(i));
            do rest();
            while (!failed);
            ++done;
          },
          [] {});
      FAIL() << "nobody goes on";
    });
    EXPECT_THAT(errors[0], FailsWith(ErrorCode::corruptFile, "piece "));
    expectNone({errors[1], errors[2]});
    EXPECT_LT(done, 499);
  }
}

TEST(WorkQueue, WhatFailsOutsideOfThePiecesEndsAllToo) {
  for (const int failing : {0, 1}) {
    const auto errors = inProcesses(3, [&](WorkQueue& distribution, int rank) {
      if (rank == failing) throw Error(ErrorCode::fileNotFound, "clouds.csv");
      distribution.each(
          "list", upTo(20), 1, [](std::size_t) { rest(); }, [] {});
    });
    EXPECT_THAT(errors[0], FailsWith(ErrorCode::fileNotFound, "clouds.csv"));
    expectNone({errors[1], errors[2]});
  }
}

TEST(WorkQueue, ProcessesThatSeeOtherWorkAreRefused) {
  const auto errors = inProcesses(2, [&](WorkQueue& distribution, int rank) {
    distribution.each(
        rank == 0 ? "a" : "b", {}, 1, [](std::size_t) {}, [] {});
  });
  EXPECT_THAT(errors[0], FailsWith(ErrorCode::mismatch, "process 1"));
}

TEST(DistributedGrid, GivesTheTableOfASingleProcess) {
  const ScratchFolder scratch;
  std::vector<Cell> cells;
  for (int i = 0; i < 40; ++i) cells.push_back({{std::to_string(i)}, "a"});
  std::atomic<int> computed = 0;
  const auto run = [&](const fs::path& folder, WorkQueue* distribution) {
    Grid grid(folder, {{"cell"}, "", {"value"}}, 2, distribution);
    Progress silent;
    const auto results = grid.run(
        cells,
        [&](std::size_t i) {
          ++computed;
          return CellResults{{"value", "", 1.0 / (1.0 + static_cast<double>(i))}};
        },
        silent, "testing");
    EXPECT_EQ(results.size(), 40U);
    EXPECT_EQ(results[39].at(0).value, 1.0 / 40) << "all know what others found";
    grid.writeCsv();
  };
  run(scratch / "alone", nullptr);
  computed = 0;
  const auto together = [&](WorkQueue& distribution, int) { run(scratch / "together", &distribution); };
  expectNone(inProcesses(3, together));
  EXPECT_EQ(computed, 40);
  EXPECT_EQ(readFile(scratch / "alone/results.csv"), readFile(scratch / "together/results.csv"));
  int kept = 0;
  for (const auto& cell : fs::directory_iterator(scratch / "together/cells"))
    if (kept++ % 4 == 0) fs::remove(cell);
  computed = 0;
  expectNone(inProcesses(3, together));
  EXPECT_EQ(computed, 10) << "only what is missing";
  EXPECT_EQ(readFile(scratch / "alone/results.csv"), readFile(scratch / "together/results.csv"));
}

}  // namespace
}  // namespace estancia::experiments
