// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/memory.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/support.hpp"

namespace estancia {
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

TEST(Memory, AMachineWithoutNumbersSetsNoLimit) {
  const test::ScratchFolder root;
  EXPECT_EQ(availableMemory(root.path()), unlimited);
  test::writeFile(root / "proc/meminfo", "MemTotal: 100 kB\nMemAvailable: lots\n");
  test::writeFile(root / "proc/self/cgroup", "nonsense\n0:\n::\n");
  EXPECT_EQ(availableMemory(root.path()), unlimited);
}

TEST(Memory, AnyGroupAroundLimits) {
  const test::ScratchFolder root;
  test::writeFile(root / "proc/meminfo", "MemAvailable:   8000 kB\n");
  test::writeFile(root / "proc/self/cgroup", "0::/service/robot\n");
  test::writeFile(root / "sys/fs/cgroup/service/robot/memory.max", "max\n");
  test::writeFile(root / "sys/fs/cgroup/service/robot/memory.current", "5000\n");
  EXPECT_EQ(availableMemory(root.path()), 8000U * 1024);
  test::writeFile(root / "sys/fs/cgroup/service/memory.max", "7000\n");
  EXPECT_EQ(availableMemory(root.path()), 8000U * 1024) << "a limit without its usage says nothing";
  test::writeFile(root / "sys/fs/cgroup/service/memory.current", "6000\n");
  EXPECT_EQ(availableMemory(root.path()), 1000U);
  test::writeFile(root / "sys/fs/cgroup/service/memory.stat", "anon 2000\ninactive_file 4000\n");
  EXPECT_EQ(availableMemory(root.path()), 5000U) << "pages of files are given back";
  test::writeFile(root / "sys/fs/cgroup/service/memory.max", "100\n");
  EXPECT_EQ(availableMemory(root.path()), 0U) << "never below nothing";
}

TEST(Memory, GroupsOfTheFirstKindLimitToo) {
  const test::ScratchFolder root;
  test::writeFile(root / "proc/self/cgroup", "5:cpu:/other\n4:hugetlb,memory:/robot\n");
  test::writeFile(root / "sys/fs/cgroup/memory/robot/memory.limit_in_bytes", "9000\n");
  test::writeFile(root / "sys/fs/cgroup/memory/robot/memory.usage_in_bytes", "4000\n");
  test::writeFile(root / "sys/fs/cgroup/memory/robot/memory.stat", "cache 3000\ntotal_inactive_file 1000\n");
  EXPECT_EQ(availableMemory(root.path()), 6000U);
}

}  // namespace
}  // namespace estancia
