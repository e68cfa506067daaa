// Signaled command: starts the command, waits until it is time, sends it a signal.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace estancia::test {

/// Starts the command, whose output is discarded and which has no labels but those of `cache`, and sends
/// `signal` when `isTime` has been true for `later`. Returns the status of waitpid(), also of a command that
/// ends by itself before. How long to wait is ctest's limit.
template <class IsTime>
int signalCommand(const std::vector<std::string>& arguments, const std::filesystem::path& cache,
                  const IsTime& isTime, std::chrono::milliseconds later, int signal) {
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) dup2(nowhere, stream);
    std::vector<char*> argv{const_cast<char*>(ESTANCIA_COMMAND)};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    setenv("ESTANCIA_CACHE", cache.c_str(), 1);
    execv(ESTANCIA_COMMAND, argv.data());
    _exit(127);
  }
  int status = 0;
  while (!isTime()) {
    if (waitpid(child, &status, WNOHANG) != 0) return status;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::this_thread::sleep_for(later);
  kill(child, signal);
  waitpid(child, &status, 0);
  return status;
}

}  // namespace estancia::test
