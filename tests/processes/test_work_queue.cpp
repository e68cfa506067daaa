// SPDX-License-Identifier: Apache-2.0
#include "estancia/processes/work_queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "processes/local_ranks.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

using test::expectNone;
using test::FailsWith;
using test::inProcesses;
using test::LocalRanks;

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

TEST(WorkQueue, AFailureOfAnyTypeInAnotherProcessIsToldByTheFirst) {
  const std::pair<std::function<void()>, ErrorCode> failures[] = {
      {[] { throw std::out_of_range("piece 7"); }, ErrorCode::invalidState},
      {[] { throw 7; }, ErrorCode::invalidState},
      {[] { throw Interrupted("stopped"); }, ErrorCode::interrupted}};
  for (const auto& [fail, code] : failures) {
    const auto errors = inProcesses(2, [&, &fail = fail](WorkQueue& distribution, int rank) {
      if (rank == 1) fail();
      distribution.each(
          "list", upTo(3), 1, [](std::size_t) {}, [] {});
    });
    EXPECT_THAT(errors[0], FailsWith(code));
    expectNone({errors[1]});
  }
}

TEST(WorkQueue, ProcessesThatSeeOtherWorkAreRefused) {
  const auto errors = inProcesses(2, [&](WorkQueue& distribution, int rank) {
    distribution.each(
        rank == 0 ? "a" : "b", {}, 1, [](std::size_t) {}, [] {});
  });
  EXPECT_THAT(errors[0], FailsWith(ErrorCode::mismatch, "process 1"));
}

}  // namespace
}  // namespace estancia
