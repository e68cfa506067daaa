// SPDX-License-Identifier: Apache-2.0
#include "estancia/processes/work_queue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/parallel.hpp"

namespace estancia {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto patience = 50ms;
constexpr std::size_t longest = MpiProcesses::maxBytes / 8;  // JSON may write six bytes for one

std::string text(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

/// The exception, as far as it can be sent to another process.
json wordsOf(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& e) {
    return {nameOf(e.code()), std::string(e.what()).substr(0, longest)};
  } catch (const std::exception& e) {
    return {nameOf(ErrorCode::invalidState), std::string(e.what()).substr(0, longest)};
  } catch (...) {
    return {nameOf(ErrorCode::invalidState), "an unknown failure"};
  }
}

std::exception_ptr failureOf(const json& failure) {
  const ErrorCode code = findErrorCode(failure.at(0).get<std::string>()).value_or(ErrorCode::invalidState);
  const std::string why = failure.at(1);
  return code == ErrorCode::interrupted ? std::make_exception_ptr(Interrupted(why))
                                        : std::make_exception_ptr(Error(code, why));
}

}  // namespace

WorkQueue::WorkQueue(std::unique_ptr<MpiProcesses> ranks) : ranks_(std::move(ranks)) {
  if (isFirst()) server_ = std::thread([this] { serve(); });
}

WorkQueue::~WorkQueue() {
  if (!server_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  server_.join();
}

// ---- rank 0

void WorkQueue::serve() {
  for (;;) {
    const auto message = ranks_->receive(patience);
    const std::lock_guard lock(mutex_);
    if (message) hear(*message);
    answer();
    if (ended_ && !message) return;
  }
}

void WorkQueue::hear(const MpiProcesses::Message& message) {
  const json parts = json::parse(message.text);
  const std::string what = parts.at(0);
  if (what == "ask") {
    asked_[message.from] = {parts.at(1), parts.at(2)};
  } else if (what == "over") {
    over_.insert(message.from);
  } else if (what == "result") {
    results_[parts.at(1).get<std::size_t>()] += parts.at(2).get<std::string>();
  } else if (what == "done") {
    running_.erase(parts.at(1).get<std::size_t>());
    if (onDone_) onDone_();
  } else {
    std::optional<std::size_t> piece;
    if (!parts.at(1).is_null()) running_.erase(piece.emplace(parts.at(1).get<std::size_t>()));
    fail({piece, failureOf(parts.at(2))});
  }
  changed_.notify_all();
}

void WorkQueue::answer() {
  std::erase_if(asked_, [this](const auto& question) {
    const auto& [rank, asked] = question;
    json reply;
    const bool here = open_ && asked.phase == phase_;
    if (asked.phase == phase_ && asked.list != list_ && !failure_) {
      const std::string why = fmt::format(
          "process {} has other work than process 0; do all see the same files, and run the same Estancia?",
          rank);
      fail({std::nullopt, std::make_exception_ptr(Error(ErrorCode::mismatch, why))});
      changed_.notify_all();
    }
    if (failure_)
      reply = {"stop"};
    else if (asked.phase < phase_ || (asked.phase == phase_ && !open_) ||
             (here && queue_.empty() && running_.empty()))
      reply = {"none"};
    else if (here && !queue_.empty()) {
      reply = {"take", queue_.front()};
      running_[queue_.front()] = rank;
      queue_.pop_front();
    }
    if (!reply.is_null()) ranks_->send(rank, text(reply));
    return !reply.is_null();
  });
}

/// If several pieces fail, the failure of the first one counts.
void WorkQueue::fail(Failure failure) {
  if (!failure_ || (failure.piece && failure_->piece && *failure.piece < *failure_->piece))
    failure_ = std::move(failure);
  queue_.clear();
}

std::optional<std::size_t> WorkQueue::next() {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (interrupted() && !failure_) fail({std::nullopt, std::make_exception_ptr(Interrupted("stopped"))});
    if (failure_ || (queue_.empty() && running_.empty())) return std::nullopt;
    if (!queue_.empty()) {
      const std::size_t piece = queue_.front();
      queue_.pop_front();
      running_[piece] = 0;
      return piece;
    }
    changed_.wait_for(lock, patience);
  }
}

// ---- the others

std::optional<std::size_t> WorkQueue::ask(const std::string& list) {
  const std::lock_guard lock(asking_);
  ranks_->send(0, text({"ask", phase_, list}));
  for (;;) {
    const auto message = ranks_->receive(patience);
    if (!message) continue;  // mpirun ends us when rank 0 is no more
    const json parts = json::parse(message->text);
    if (parts.at(0) == "stop") throw Interrupted("stopped, as another process did");
    if (parts.at(0) == "none") return std::nullopt;
    return parts.at(1).get<std::size_t>();
  }
}

void WorkQueue::tell(const std::optional<std::size_t>& piece, const std::exception_ptr& failure) {
  ranks_->send(0, text({"failed", piece ? json(*piece) : json(), wordsOf(failure)}));
}

// ---- all

void WorkQueue::each(const std::string& list, const std::vector<std::size_t>& pieces, std::size_t threads,
                     const std::function<void(std::size_t)>& work, const std::function<void()>& onDone) {
  if (!isFirst()) {
    ++phase_;
    inParallel(threads, threads, [&](std::size_t) {
      while (const auto piece = ask(list)) {
        try {
          work(*piece);
        } catch (...) {
          tell(piece, std::current_exception());
          continue;  // the answer will be to stop
        }
        ranks_->send(0, text({"done", *piece}));
      }
    });
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    ++phase_;
    list_ = list;
    open_ = true;
    onDone_ = onDone;
    if (!failure_) queue_.assign(pieces.begin(), pieces.end());
  }
  inParallel(threads, threads, [&](std::size_t) {
    while (const auto piece = next()) {
      std::exception_ptr failure;
      try {
        work(*piece);
      } catch (...) {
        failure = std::current_exception();
      }
      const std::lock_guard lock(mutex_);
      running_.erase(*piece);
      if (failure) fail({piece, failure});
      changed_.notify_all();
    }
  });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return running_.empty(); });
  open_ = false;
  onDone_ = nullptr;
  if (failure_) std::rethrow_exception(failure_->what);
}

std::vector<std::string> WorkQueue::results(const std::string& list, std::size_t count,
                                            const std::function<std::string(std::size_t)>& work,
                                            const std::function<void()>& onDone) {
  std::vector<std::size_t> pieces(isFirst() ? count : 0);
  std::iota(pieces.begin(), pieces.end(), std::size_t{0});
  std::vector<std::string> own(pieces.size());
  each(
      list, pieces, 1,
      [&](std::size_t piece) {
        const std::string result = work(piece);
        if (isFirst()) {
          own[piece] = result;
          return onDone();
        }
        for (std::size_t begin = 0; begin < result.size(); begin += longest)
          ranks_->send(0, text({"result", piece, result.substr(begin, longest)}));
      },
      onDone);
  const std::lock_guard lock(mutex_);
  for (auto& [piece, result] : results_) own[piece] = std::move(result);
  results_.clear();
  return own;
}

void WorkQueue::together(const std::function<void()>& program) {
  std::exception_ptr failure;
  try {
    program();
  } catch (...) {
    failure = std::current_exception();
  }
  if (!isFirst()) {
    if (failure) tell(std::nullopt, failure);
    ranks_->send(0, text({"over"}));
    ranks_->leave();
    return;
  }
  {
    std::unique_lock lock(mutex_);
    if (failure) fail({std::nullopt, failure});
    changed_.wait(lock, [this] { return over_.size() + 1 == static_cast<std::size_t>(ranks_->size()); });
    if (!failure && failure_) failure = failure_->what;
    ended_ = true;
  }
  server_.join();
  ranks_->leave();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace estancia
