// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"

namespace estancia {

void inParallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t failedAt = count;
  std::exception_ptr failure;
  const auto labor = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        next = count;
        if (i < failedAt) {
          failedAt = i;
          failure = std::current_exception();
        }
      }
    }
  };
  std::vector<std::thread> others;
  try {
    others.reserve(std::min(threads, count));
    for (std::size_t i = 1; i < std::min(threads, count); ++i) others.emplace_back(labor);
  } catch (const std::exception&) {
    // The system gives no more; those that are there do the work.
  }
  labor();
  for (std::thread& other : others) other.join();
  if (failure) std::rethrow_exception(failure);
}

void inParallel(std::size_t count, int threads, Progress& progress, const std::string& stopped,
                const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> done = 0;
  std::size_t told = 0;  // by the caller's own thread, which alone may touch its progress
  const auto caller = std::this_thread::get_id();
  inParallel(count, static_cast<std::size_t>(threads > 0 ? threads : usableCores()), [&](std::size_t i) {
    if (interrupted()) throw Interrupted(stopped);
    work(i);
    const std::size_t now = ++done;
    if (std::this_thread::get_id() != caller) return;
    progress.advance(now - told);
    told = now;
  });
  progress.advance(count - told);
}

}  // namespace estancia
