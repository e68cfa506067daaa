// World reader: a thread that reads a map file whenever it has changed. Private to LiveLoop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

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
  WorldReader(std::filesystem::path path, const Options& options, Take take);
  ~WorldReader();
  WorldReader(const WorldReader&) = delete;
  WorldReader& operator=(const WorldReader&) = delete;

  /// The file has changed; a number for wait(). Reading takes a tenth of the time, unless a caller waits.
  std::uint64_t request();
  /// Until the file has been read as of that request or later; at once where there is no file yet.
  void wait(std::uint64_t number);

 private:
  void run();

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
