// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/cores.hpp"
#include "estancia/core/progress.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <limits>
#include <string>

#include "estancia/core/memory.hpp"
#include "estancia/core/time_left.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

/// The wait status of a process that catches interrupts and gets `signal` twice. It ends with 1 when it has
/// been asked to stop, else with 0.
int statusAfter(int signal, bool ignoredBefore) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(signal, ignoredBefore ? SIG_IGN : SIG_DFL);
    catchInterrupts();
    for (int i = 0; i < 2; ++i) std::raise(signal);
    _exit(interrupted() ? 1 : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST(Interrupts, AClosedTerminalAsksToStopHoweverOftenItSaysSo) {
  const int status = statusAfter(SIGHUP, false);
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

TEST(Interrupts, NohupStaysInForce) {
  const int status = statusAfter(SIGHUP, true);
  ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(Interrupts, TheSecondSigtermKills) {
  const int status = statusAfter(SIGTERM, false);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
}

TEST(Interrupts, TheFirstOneKillsWhereNobodyAsks) {
  const auto neverAsks = [] {
    catchInterrupts();
    std::raise(SIGTERM);
    for (unsigned left = 60; left > 0;) left = sleep(left);  // SIGALRM wakes it
    _exit(2);
  };
  EXPECT_EXIT(neverAsks(), testing::KilledBySignal(SIGTERM), "");
}

TEST(StderrProgress, ShowsWorkThatHasAName) {
  testing::internal::CaptureStderr();
  {
    const auto progress = makeStderrProgress();
    progress->advance(1);  // begun by no caller
    progress->begin("mapping", 2);
    progress->advance(2);
    progress->end();
    progress->advance(1);
  }
  const std::string shown = testing::internal::GetCapturedStderr();
  EXPECT_EQ(shown.find("mapping 100 % 2/2"), 0U) << shown;
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 1) << shown;
}

TEST(TimeLeft, DoesNotCountTheStart) {
  TimeLeft left(100);
  EXPECT_FALSE(left.seconds(4));
  left.advance(1, 5);  // five seconds for opening the network
  EXPECT_FALSE(left.seconds(5)) << "of one item nothing can be told";
  for (int i = 1; i <= 12; ++i) left.advance(1, 5 + 0.5 * i);
  EXPECT_DOUBLE_EQ(left.rate(11).value(), 2);
  EXPECT_DOUBLE_EQ(left.seconds(11).value(), 87 / 2.0);
}

TEST(TimeLeft, CountsOnlyWhatWasDoneInThisRun) {
  TimeLeft left(1000, 900);
  left.advance(1, 1);
  left.advance(9, 4);
  EXPECT_EQ(left.done(), 910U);
  EXPECT_DOUBLE_EQ(left.seconds(4).value(), 30);
}

/// The cores that the test may really use.
int allowed() {
  cpu_set_t mask;
  CPU_ZERO(&mask);
  sched_getaffinity(0, sizeof mask, &mask);
  return CPU_COUNT(&mask);
}

TEST(Cores, AtLeastOneAndAtMostTheUsableOnesAreFree) {
  EXPECT_GE(usableCores(), 1);
  EXPECT_LE(usableCores(), allowed());
  EXPECT_GE(freeCores(), 1);
  EXPECT_LE(freeCores(), usableCores());
}

TEST(Cores, TheQuotaOfAnyGroupAroundLimits) {
  const test::ScratchFolder root;
  test::writeFile(root / "proc/self/cgroup", "0::/service/robot\n");
  test::writeFile(root / "sys/fs/cgroup/service/robot/cpu.max", "max 100000\n");
  EXPECT_EQ(usableCores(root.path()), allowed());
  test::writeFile(root / "sys/fs/cgroup/service/cpu.max", "150000 100000\n");
  EXPECT_EQ(usableCores(root.path()), 1);
  test::writeFile(root / "sys/fs/cgroup/service/cpu.max", "5000 100000\n");
  EXPECT_EQ(usableCores(root.path()), 1) << "never none";
}

TEST(Cores, QuotasOfTheFirstKindLimitToo) {
  const test::ScratchFolder root;
  test::writeFile(root / "proc/self/cgroup", "7:memory:/\n4:cpu,cpuacct:/robot\n");
  test::writeFile(root / "sys/fs/cgroup/cpu/robot/cpu.cfs_quota_us", "-1\n");
  test::writeFile(root / "sys/fs/cgroup/cpu/robot/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(usableCores(root.path()), allowed());
  test::writeFile(root / "sys/fs/cgroup/cpu/robot/cpu.cfs_quota_us", "100000\n");
  EXPECT_EQ(usableCores(root.path()), 1);
}

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

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
