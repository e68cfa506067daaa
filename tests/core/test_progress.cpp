// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/cores.hpp"
#include "estancia/core/progress.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
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

TEST(Interrupts, AClosedTerminalAsksToStopHoweverOftenItSaysSoUnlessNohupIsInForce) {
  for (const bool nohup : {false, true}) {
    const int status = statusAfter(SIGHUP, nohup);
    ASSERT_TRUE(WIFEXITED(status)) << "killed by signal " << WTERMSIG(status);
    EXPECT_EQ(WEXITSTATUS(status), nohup ? 0 : 1);
  }
}

TEST(Interrupts, TheSecondSigtermKillsAndTheFirstWhereNobodyAsks) {
  const int status = statusAfter(SIGTERM, false);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
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

TEST(StderrProgress, DrawsABarThatFitsTheTerminal) {
  const int screen = posix_openpt(O_RDWR | O_NOCTTY), ours = dup(STDERR_FILENO);
  if (screen < 0 || grantpt(screen) != 0 || unlockpt(screen) != 0) GTEST_SKIP() << "no pseudo terminals here";
  const int terminal = open(ptsname(screen), O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  for (const unsigned short columns : {0, 30, 80}) {
    const winsize size{24, columns, 0, 0};
    ASSERT_EQ(ioctl(terminal, TIOCSWINSZ, &size), 0);
    dup2(terminal, STDERR_FILENO);
    {
      const auto progress = makeStderrProgress();
      progress->begin("mapping the whole flat", 4, 2);
      clearProgressLine();
    }
    dup2(ours, STDERR_FILENO);
    std::string shown;
    pollfd ready{screen, POLLIN, 0};
    for (char c = 0; c != '\n' && poll(&ready, 1, 10'000) == 1 && read(screen, &c, 1) == 1;) shown += c;
    EXPECT_EQ(shown.find("\r\033[Kmapping the whole flat "), 0U) << shown;
    EXPECT_EQ(shown.find("█░") != std::string::npos, columns != 30) << "half done, if a bar fits: " << shown;
    EXPECT_EQ(shown.find("50 % 2/4") != std::string::npos, columns != 30) << shown;
  }
  for (const int file : {terminal, screen, ours}) close(file);
}

TEST(TimeLeft, CountsNeitherTheStartNorWhatAnEarlierRunHasDone) {
  TimeLeft left(100);
  EXPECT_FALSE(left.seconds(4));
  left.advance(1, 5);  // five seconds for opening the network
  EXPECT_FALSE(left.seconds(5)) << "of one item nothing can be told";
  for (int i = 1; i <= 12; ++i) left.advance(1, 5 + 0.5 * i);
  EXPECT_DOUBLE_EQ(left.rate(11).value(), 2);
  EXPECT_DOUBLE_EQ(left.seconds(11).value(), 87 / 2.0);
  TimeLeft resumed(1000, 900);
  resumed.advance(1, 1);
  resumed.advance(9, 4);
  EXPECT_EQ(resumed.done(), 910U);
  EXPECT_DOUBLE_EQ(resumed.seconds(4).value(), 30);
  resumed.advance(90, 5);
  EXPECT_DOUBLE_EQ(resumed.seconds(5).value(), 0) << "complete";
  TimeLeft endless;
  for (const double now : {1, 4}) endless.advance(3, now);
  EXPECT_FALSE(endless.isComplete() || endless.seconds(4)) << "of no known amount nothing is left";
  EXPECT_DOUBLE_EQ(endless.rate(4).value(), 1);
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

TEST(Cores, OnlyTheCoresInQuestionCountAsBusy) {
  const std::string stat =
      "cpu  111 222 333 444 0 0 0 0 0 0\ncpu0 1 2 4 1000 2000 8 16 32 0 0\ncpu1 100 0 0 5000 0 0 0 0 0 0\n"
      "cpu12 7 0 0 5000 0 0 0 0 0 0\ncpu13 none\nintr 5 6\n";
  EXPECT_EQ(busyTicks(stat, {0}), 1 + 2 + 4 + 8 + 16 + 32);
  EXPECT_EQ(busyTicks(stat, {1, 12}), 107);
  EXPECT_EQ(busyTicks(stat, {0, 13}), -1) << "cpu13 is missing";
}

TEST(Cores, TheQuotaOfAnyGroupOfEitherKindLimits) {
  const test::ScratchFolder root;
  test::writeFile(root / "proc/self/cgroup", "nonsense\n0:\n::\n");
  EXPECT_EQ(usableCores(root.path()), allowed()) << "a machine that does not tell has all of them";
  test::writeFile(root / "proc/self/cgroup", "0::/service/robot\n");
  test::writeFile(root / "sys/fs/cgroup/service/robot/cpu.max", "max 100000\n");
  EXPECT_EQ(usableCores(root.path()), allowed());
  test::writeFile(root / "sys/fs/cgroup/service/cpu.max", "150000 100000\n");
  EXPECT_EQ(usableCores(root.path()), 1);
  test::writeFile(root / "sys/fs/cgroup/service/cpu.max", "5000 100000\n");
  EXPECT_EQ(usableCores(root.path()), 1) << "never none";
  const test::ScratchFolder first;
  test::writeFile(first / "proc/self/cgroup", "7:memory:/\n4:cpu,cpuacct:/robot\n");
  test::writeFile(first / "sys/fs/cgroup/cpu/robot/cpu.cfs_quota_us", "-1\n");
  test::writeFile(first / "sys/fs/cgroup/cpu/robot/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(usableCores(first.path()), allowed());
  test::writeFile(first / "sys/fs/cgroup/cpu/robot/cpu.cfs_quota_us", "100000\n");
  EXPECT_EQ(usableCores(first.path()), 1);
}

TEST(Memory, ALimitOfTheShellCounts) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  const rlimit lower{std::min<rlim_t>(before.rlim_max, rlim_t{1} << 48), before.rlim_max};
  const test::ScratchFolder root;
  test::writeFile(root / "proc/self/status", "VmPeak: 9 kB\nVmSize:\t1048576 kB\n");
  ASSERT_EQ(setrlimit(RLIMIT_AS, &lower), 0);
  rlimit now{};
  if (getrlimit(RLIMIT_AS, &now) != 0 || now.rlim_cur != lower.rlim_cur)
    GTEST_SKIP() << "an emulated processor has no such limit";
  EXPECT_EQ(availableMemory(root.path()), lower.rlim_cur - (1U << 30)) << "less what this process has";
  setrlimit(RLIMIT_AS, &before);
}

TEST(Memory, AnyGroupOfEitherKindLimits) {
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
  const test::ScratchFolder first;
  test::writeFile(first / "proc/self/cgroup", "5:cpu:/other\n4:hugetlb,memory:/robot\n");
  test::writeFile(first / "sys/fs/cgroup/memory/robot/memory.limit_in_bytes", "9000\n");
  test::writeFile(first / "sys/fs/cgroup/memory/robot/memory.usage_in_bytes", "4000\n");
  test::writeFile(first / "sys/fs/cgroup/memory/robot/memory.stat", "cache 3000\ntotal_inactive_file 1000\n");
  EXPECT_EQ(availableMemory(first.path()), 6000U);
}

}  // namespace
}  // namespace estancia
