// Topics of ROS 2: how many raw images arrive of a node with ROS 2's settings, in a process of its own on the
// loopback.
//   bench_dds [SECONDS [HERTZ [WIDTH HEIGHT]]]   default: 10 s, 20 Hz, 640 × 480, rgb8
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "estancia/ros/dds.hpp"

#ifndef ESTANCIA_DDS_WRITER
#define ESTANCIA_DDS_WRITER ""  // built without the tests
#endif

namespace {

using namespace estancia;
using Clock = std::chrono::steady_clock;

struct Stream {
  int seconds = 10, hertz = 20;
  std::size_t width = 640, height = 480;
};

int write(int domain, const Stream& stream, const std::string& quality) {
  const std::vector<std::string> words{ESTANCIA_DDS_WRITER,
                                       std::to_string(domain),
                                       "rt/camera/image_raw",
                                       "sensor_msgs::msg::dds_::Image_",
                                       std::to_string(stream.width * stream.height * 3 + 64),
                                       std::to_string(stream.hertz),
                                       std::to_string(stream.seconds * stream.hertz),
                                       quality};
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", 1, 0);
  pid_t pid = -1;
  if (posix_spawn(&pid, arguments[0], &actions, nullptr, arguments.data(), environ) != 0)
    throw std::runtime_error(
        "no writer; build the tests too (ESTANCIA_BUILD_TESTS), where Fast DDS is installed");
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  waitpid(pid, &status, 0);
  return status;
}

void measure(const Stream& stream, const std::string& quality) {
  const int domain = 1 + static_cast<int>(getpid() % 100);
  const auto node = ros::makeDdsNode(domain);
  std::mutex mutex;
  std::vector<double> gaps;
  auto last = Clock::time_point::min();
  const auto subscription =
      node->subscribe("/camera/image_raw", "sensor_msgs/Image", [&](std::span<const std::byte>) {
        const std::lock_guard lock(mutex);
        const auto now = Clock::now();
        if (last != Clock::time_point::min())
          gaps.push_back(std::chrono::duration<double, std::milli>(now - last).count());
        last = now;
      });
  if (write(domain, stream, quality) != 0) throw std::runtime_error("the writer failed");
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const ros::DdsCounts counts = subscription->counts();
  const std::lock_guard lock(mutex);
  std::sort(gaps.begin(), gaps.end());
  const int written = stream.seconds * stream.hertz;
  fmt::print(
      "{:11} {} of {} images of {} × {} at {} Hz: {:.1f} %, {} known to be lost; longest gap {:.0f} ms\n",
      quality, counts.received, written, stream.width, stream.height, stream.hertz,
      100.0 * static_cast<double>(counts.received) / written, counts.lost, gaps.empty() ? 0.0 : gaps.back());
}

}  // namespace

int main(int count, char** words) {
  try {
    Stream stream;
    if (count > 1) stream.seconds = std::stoi(words[1]);
    if (count > 2) stream.hertz = std::stoi(words[2]);
    if (count > 4) stream.width = std::stoul(words[3]), stream.height = std::stoul(words[4]);
    setenv("ROS_LOCALHOST_ONLY", "1", 1);
    for (const char* quality : {"reliable", "best-effort"}) measure(stream, quality);
    return 0;
  } catch (const std::exception& failure) {
    fmt::print(stderr, "bench_dds: {}\n", failure.what());
    return 1;
  }
}
