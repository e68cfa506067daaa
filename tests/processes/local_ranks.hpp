// Ranks that are threads of one process.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "estancia/processes/work_queue.hpp"
#include "support/errors.hpp"

namespace estancia::test {

class LocalRanks final : public MpiProcesses {
 public:
  /// So many that know each other.
  static std::vector<std::unique_ptr<MpiProcesses>> several(int count) {
    const auto post = std::make_shared<Post>();
    post->boxes.resize(static_cast<std::size_t>(count));
    std::vector<std::unique_ptr<MpiProcesses>> ranks;
    for (int i = 0; i < count; ++i) ranks.push_back(std::make_unique<LocalRanks>(post, i));
    return ranks;
  }

  struct Post {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::deque<Message>> boxes;
    std::size_t left = 0;
  };
  LocalRanks(std::shared_ptr<Post> post, int rank) : post_(std::move(post)), rank_(rank) {}

  int rank() const override { return rank_; }
  int size() const override { return static_cast<int>(post_->boxes.size()); }

  void send(int to, const std::string& text) override {
    const std::lock_guard lock(post_->mutex);
    post_->boxes.at(static_cast<std::size_t>(to)).push_back({rank_, text.substr(0, maxBytes)});
    post_->changed.notify_all();
  }

  std::optional<Message> receive(std::chrono::milliseconds patience) override {
    std::unique_lock lock(post_->mutex);
    auto& box = post_->boxes[static_cast<std::size_t>(rank_)];
    if (!post_->changed.wait_for(lock, patience, [&] { return !box.empty(); })) return std::nullopt;
    Message message = box.front();
    box.pop_front();
    return message;
  }

  void leave() override {
    std::unique_lock lock(post_->mutex);
    ++post_->left;
    post_->changed.notify_all();
    post_->changed.wait(lock, [&] { return post_->left == post_->boxes.size(); });
  }

 private:
  std::shared_ptr<Post> post_;
  int rank_;
};

/// Runs program(distribution, rank) in so many processes that are threads; what they throw.
inline std::vector<Caught> inProcesses(int count, const std::function<void(WorkQueue&, int)>& program) {
  auto ranks = LocalRanks::several(count);
  std::vector<Caught> errors(static_cast<std::size_t>(count));
  std::vector<std::thread> processes;
  for (int r = 0; r < count; ++r)
    processes.emplace_back([&, r] {
      const auto i = static_cast<std::size_t>(r);
      WorkQueue distribution(std::move(ranks[i]));
      errors[i] = caught([&] { distribution.together([&] { program(distribution, r); }); });
    });
  for (std::thread& process : processes) process.join();
  return errors;
}

inline void expectNone(const std::vector<Caught>& errors) {
  for (const Caught& error : errors) EXPECT_FALSE(error.code) << error;
}

}  // namespace estancia::test
