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

void inParallel(std::size_t count, int threads, Progress& progress, const std::string& stopped,
                const std::function<void(std::size_t)>& task) {
  std::atomic<std::size_t> next = 0, done = 0;
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&](auto&& tell) {
    for (std::size_t i = next++; i < count && !interrupted(); i = next++) {
      try {
        task(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
        return;
      }
      ++done;
      tell();
    }
  };
  std::vector<std::thread> others;
  const std::size_t most = std::min(count, static_cast<std::size_t>(threads > 0 ? threads : usableCores()));
  for (std::size_t t = 1; t < most; ++t) others.emplace_back(work, [] {});
  std::size_t told = 0;
  work([&] {
    const std::size_t now = done;
    progress.advance(now - told);
    told = now;
  });
  for (std::thread& other : others) other.join();
  if (failure) std::rethrow_exception(failure);
  if (done < count) throw Interrupted(stopped);
  progress.advance(count - told);
}

void inParallel(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t failedAt = count;
  std::exception_ptr failure;
  const auto labour = [&] {
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
  for (std::size_t i = 1; i < std::min(threads, count); ++i) others.emplace_back(labour);
  labour();
  for (std::thread& other : others) other.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace estancia
