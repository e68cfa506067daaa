// Process group: child processes that are killed when their owner ends, however it ends; declared in
// line_process.hpp.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/no_sigpipe.hpp"
#include "estancia/labelers/line_process.hpp"

namespace estancia {
namespace {

/// Reads the child's number, then waits for the end of the file. The guard is in the group itself, so that no
/// other process can have been given the group's number meanwhile. The child may lead a group of its own by
/// now (setsid), or not have been started.
constexpr const char* guardScript = "read -r child; read -r end; kill -KILL ${child:+$child -$child} 0";

/// Duplicates a file descriptor above stdin, stdout and stderr, which are not always open.
int above(int file) {
  const int moved = fcntl(file, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  ::close(file);
  return moved;
}

/// Runs the guard with all signals blocked: what stops or ends the group by name must not end it.
int spawnGuard(int input, pid_t& guard) {
  std::string shell = "sh", option = "-c", script = guardScript;
  const std::array<char*, 4> arguments{shell.data(), option.data(), script.data(), nullptr};
  const std::array<char*, 1> environment{nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  posix_spawnattr_t how;
  posix_spawnattr_init(&how);
  sigset_t all;
  sigfillset(&all);
  posix_spawnattr_setpgroup(&how, 0);
  posix_spawnattr_setsigmask(&how, &all);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  const int problem = posix_spawn(&guard, "/bin/sh", &actions, &how, arguments.data(), environment.data());
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&actions);
  return problem;
}

}  // namespace

ProcessGroup::ProcessGroup() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0)
    fail(ErrorCode::labelerFailure, "cannot make a pipe: {}", std::strerror(errno));
  const int input = above(ends[0]);
  lifeline_ = above(ends[1]);
  const int problem = input < 0 || lifeline_ < 0 ? EMFILE : spawnGuard(input, guard_);
  ::close(input);
  if (problem == 0) return;
  ::close(lifeline_);
  fail(ErrorCode::labelerFailure,
       "cannot run /bin/sh ({}), which ends label programs with Estancia; install it",
       std::strerror(problem));
}

void ProcessGroup::include(pid_t child) {
  const std::string line = fmt::format("{}\n", child);
  const NoSigpipe quiet;  // should the guard be gone
  [[maybe_unused]] const ssize_t written = ::write(lifeline_, line.data(), line.size());
}

void ProcessGroup::kill() {
  if (guard_ < 0) return;
  ::kill(-guard_, SIGKILL);
  ::close(std::exchange(lifeline_, -1));
  while (waitpid(guard_, nullptr, 0) < 0 && errno == EINTR) {
  }
  guard_ = -1;
}

}  // namespace estancia
