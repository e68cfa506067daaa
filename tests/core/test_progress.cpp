// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/progress.hpp"
#include "estancia/core/time_left.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <string>

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
    progress->advance(1);  // begun by nobody
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

}  // namespace
}  // namespace estancia
