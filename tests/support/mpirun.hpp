// Mpirun: tests that start the command in several processes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "support/support.hpp"

namespace estancia::test {

class MpirunTest : public testing::Test {
 protected:
  void SetUp() override {
    const bool missing = !isThere("mpirun");
    if (missing && std::getenv("CI") != nullptr) FAIL() << "mpirun is not here; script/bootstrap installs it";
    ESTANCIA_NEEDS(!missing, "mpirun is not here");
    // Open MPI frees little at its end, in components that it has closed by then, so that no suppression
    // names them.
    if (const char* sanitizer = std::getenv("ASAN_OPTIONS"))
      setenv("ASAN_OPTIONS", (std::string(sanitizer) + ":detect_leaks=0").c_str(), 1);
  }

  static bool isThere(const std::string& program) {
    std::stringstream folders(std::getenv("PATH") != nullptr ? std::getenv("PATH") : "");
    for (std::string folder; std::getline(folders, folder, ':');)
      if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
    return false;
  }

  /// Starts mpirun with its streams in files.
  pid_t start(int ranks, const std::vector<std::string>& arguments) const {
    const pid_t child = fork();
    if (child != 0) return child;
    const std::string log = (scratch_ / "err").string(), said = (scratch_ / "out.txt").string(),
                      count = std::to_string(ranks);
    dup2(open("/dev/null", O_RDONLY), 0);
    dup2(open(said.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 1);
    dup2(open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
    setenv("ESTANCIA_CACHE", (scratch_ / "cache").c_str(), 1);
    setenv("ASAN_OPTIONS", "detect_leaks=0", 0);  // leaks of Open MPI
    std::vector<std::string> words{
        "mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n",
        count,    ESTANCIA_COMMAND};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    execvp("mpirun", pointers.data());
    _exit(127);
  }

  CommandResult finish(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), readFile(scratch_ / "out.txt"),
            readFile(scratch_ / "err")};
  }

  ScratchFolder scratch_;
};

}  // namespace estancia::test
