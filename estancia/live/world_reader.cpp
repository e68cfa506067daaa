// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/world_reader.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "estancia/live/background_thread.hpp"
#include "estancia/world/rooms_by_name.hpp"

namespace estancia {

WorldReader::WorldReader(std::filesystem::path path, const Options& options, Take take)
    : path_(std::move(path)), options_(options), take_(std::move(take)), thread_([this] { run(); }) {}

WorldReader::~WorldReader() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::uint64_t WorldReader::request() {
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
  return ++requested_;
}

void WorldReader::wait(std::uint64_t number) {
  std::unique_lock lock(mutex_);
  awaited_ = std::max(awaited_, number);
  changed_.notify_all();
  changed_.wait(lock, [&] { return ending_ || done_ >= number; });
}

void WorldReader::run() {
  using Clock = std::chrono::steady_clock;
  constexpr int timesOfReading = 10;
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
    next = Clock::now() + timesOfReading * (processorTime() - begin);
    lock.lock();
    done_ = number;
    changed_.notify_all();
  }
}

}  // namespace estancia
