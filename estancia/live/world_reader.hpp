// World reader: a thread that reads a map file whenever it has changed. Private to LiveLoop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "estancia/live/background_thread.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// Reads a map file in a thread of its own whenever requests are newer than the last reading. Invariant:
/// done_ ≤ requested_, both only grow, and mutex_ guards them. The destructor waits for a reading in
/// progress.
class WorldReader {
 public:
  using Take = std::function<void(std::shared_ptr<const WorldMap>)>;
  struct Options {
    /// Limit of frames that are read, so that memory stays bounded while the map grows.
    std::size_t maxFrames = std::numeric_limits<std::size_t>::max();
    bool namesRooms = false;  ///< see GrowingRooms
  };
  /// `take` is called with each map that was read, in the thread.
  WorldReader(std::filesystem::path path, const Options& options, Take take)
      : path_(std::move(path)), options_(options), take_(std::move(take)), thread_([this] { run(); }) {}
  ~WorldReader() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  WorldReader(const WorldReader&) = delete;
  WorldReader& operator=(const WorldReader&) = delete;

  /// The file has changed; a number for wait(). Reading takes a tenth of the time, unless a caller waits.
  std::uint64_t request() {
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
    return ++requested_;
  }
  /// Until the file has been read as of that request or later; at once where there is no file yet.
  void wait(std::uint64_t number) {
    std::unique_lock lock(mutex_);
    awaited_ = std::max(awaited_, number);
    changed_.notify_all();
    changed_.wait(lock, [&] { return ending_ || done_ >= number; });
  }

 private:
  void run() {
    using Clock = std::chrono::steady_clock;
    takeATenth();
    Clock::time_point next;
    GrowingRooms rooms;
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return ending_ || requested_ > done_; });
      changed_.wait_until(lock, next, [this] { return ending_ || awaited_ > done_; });
      if (ending_) return;
      const std::uint64_t number = requested_;
      lock.unlock();
      const auto begin = processorTime();
      try {
        WorldMap world = readWorld(path_, options_.maxFrames);
        if (options_.namesRooms) rooms.name(path_, world);
        take_(std::make_shared<const WorldMap>(std::move(world)));
      } catch (const std::exception&) {  // not on disk yet: its first second is not over
      }
      next = Clock::now() + 10 * (processorTime() - begin);
      lock.lock();
      done_ = number;
      changed_.notify_all();
    }
  }

  std::filesystem::path path_;
  Options options_;
  Take take_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t requested_ = 0, awaited_ = 0, done_ = 0;
  bool ending_ = false;
  std::thread thread_;  // last: it uses all others
};

}  // namespace estancia
