// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>

#include "processes/local_ranks.hpp"
#include "runner/grid.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::expectNone;
using test::inProcesses;
using test::readFile;
using test::ScratchFolder;
namespace fs = std::filesystem;

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
