// A DDS domain of a test's own on the loopback, and writers in processes of their own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "estancia/ros/dds.hpp"

/// Skips the test, with a sentence, in a build without DDS: tests/CMakeLists.txt names the writer only where
/// Fast DDS is installed. With CI set that is a failure: script/bootstrap installs it.
#ifdef ESTANCIA_DDS_WRITER
#define ESTANCIA_NEEDS_DDS() static_cast<void>(0)
#else
#define ESTANCIA_NEEDS_DDS()                                                  \
  EXPECT_EQ(std::getenv("CI"), nullptr) << "there this build must speak DDS"; \
  GTEST_SKIP() << "this build speaks no DDS: libfastrtps-dev was not there"
#endif

namespace estancia::test {

/// A domain that no other test that runs now has, of those whose ports no other program is given.
inline int domainOfTest() {
  static const int domain = [] {
    setenv("ROS_LOCALHOST_ONLY", "1", 1);
    std::mt19937 generator{std::random_device{}()};
    for (;;) {
      const int number = std::uniform_int_distribution(1, 100)(generator);
      // The socket is held, and holds the domain, until the process ends.
      const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
      sockaddr_un address{};
      address.sun_family = AF_UNIX;
      // Behind a zero it is no file.
      const std::string name = "estancia-dds-" + std::to_string(number);
      name.copy(address.sun_path + 1, name.size());
      if (bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return number;
      close(socket);
    }
  }();
  return domain;
}

/// Waits until it is so; false after a minute, which only a broken program takes.
inline bool eventually(const std::function<bool()>& is) {
  for (int i = 0; i < 6000; ++i) {
    if (is()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

#ifdef ESTANCIA_DDS_WRITER

/// tests/fakes/dds_writer.cpp, a node of ROS 2 in all but its name.
class WriterProcess {
 public:
  struct Job {
    std::string topic = "rt/camera/image_raw", type = "sensor_msgs::msg::dds_::Image_";
    std::size_t bytes = 100;
    int hertz = 20, count = 0;
    std::string quality = "reliable";
  };

  WriterProcess(int domain, const Job& job) {
    const std::vector<std::string> words{
        ESTANCIA_DDS_WRITER,       std::to_string(domain),    job.topic,  job.type, std::to_string(job.bytes),
        std::to_string(job.hertz), std::to_string(job.count), job.quality};
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", 1, 0);
    EXPECT_EQ(posix_spawn(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  ~WriterProcess() { end(SIGTERM); }
  WriterProcess(const WriterProcess&) = delete;
  WriterProcess& operator=(const WriterProcess&) = delete;

  void end(int signal) {
    if (pid_ > 0) kill(pid_, signal);
    wait();
  }
  /// Its exit code.
  int wait() {
    if (pid_ <= 0) return code_;
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  int code_ = -1;
};

#endif

}  // namespace estancia::test
