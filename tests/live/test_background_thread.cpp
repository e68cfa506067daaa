// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/background_thread.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <thread>

namespace estancia {
namespace {

using namespace std::chrono_literals;

TEST(BackgroundThread, CountsWhatItHadOfTheProcessorsAlone) {
  const auto inAThread = [](auto work) {
    return std::async(std::launch::async,
                      [work] {
                        const auto begin = processorTime();
                        work();
                        return processorTime() - begin;
                      })
        .get();
  };
  EXPECT_LT(inAThread([] { std::this_thread::sleep_for(200ms); }), 100ms);
  EXPECT_GE(inAThread([] {
              const auto end = processorTime() + 20ms;
              while (processorTime() < end) continue;
            }),
            20ms);
}

}  // namespace
}  // namespace estancia
