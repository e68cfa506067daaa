// Work queue: pieces of work shared by several processes; a free one takes the next.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "estancia/core/progress.hpp"
#include "estancia/processes/mpi_processes.hpp"

namespace estancia {

/// All processes run the same program, in which together() and each() are called by all in the same order.
/// Rank 0 gives out the pieces, by a thread of its own that hardly costs, and works like the others.
/// Invariant: results are in the order of the pieces, whichever process computed them. Life cycle: made once
/// a program on each process; a failure on one process ends the work on all.
class WorkQueue {
 public:
  explicit WorkQueue(std::unique_ptr<MpiProcesses> ranks);
  ~WorkQueue();
  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;

  bool isFirst() const { return ranks_->rank() == 0; }
  int processes() const { return ranks_->size(); }

  /// Runs `program` and returns when all have. At rank 0 throws what it threw, or else Error with what it
  /// threw at another; the others report to rank 0 and return. To be called once.
  void together(const std::function<void()>& program);

  /// Calls work(i) for each i of rank 0's `pieces`, once, on `threads` threads of one of the processes;
  /// returns when all is done everywhere. `list` describes what the numbers mean: the same in all. `onDone`
  /// is called at rank 0 for each piece that another process has done. A failure ends the work when the
  /// pieces that run have ended: rank 0 throws that of the first piece, others Interrupted.
  void each(const std::string& list, const std::vector<std::size_t>& pieces, std::size_t threads,
            const std::function<void(std::size_t)>& work, const std::function<void()>& onDone);

  /// Calls work(i) for all pieces below `count`, one at a time in each process. At rank 0 gives what work(i)
  /// returned, by i; at the others nothing.
  std::vector<std::string> results(const std::string& list, std::size_t count,
                                   const std::function<std::string(std::size_t)>& work,
                                   const std::function<void()>& onDone);

 private:
  struct Failure {
    std::optional<std::size_t> piece;  // none: outside of each()
    std::exception_ptr what;
  };
  struct Asked {
    std::size_t phase;
    std::string list;
  };

  // Rank 0, under mutex_.
  void serve();
  void hear(const MpiProcesses::Message& message);
  void answer();
  void fail(Failure failure);
  std::optional<std::size_t> next();

  // The others.
  std::optional<std::size_t> ask(const std::string& list);
  void tell(const std::optional<std::size_t>& piece, const std::exception_ptr& failure);

  std::unique_ptr<MpiProcesses> ranks_;
  std::mutex mutex_, asking_;
  std::size_t phase_ = 0;  // calls of each() until now
  std::condition_variable changed_;
  std::thread server_;
  bool ended_ = false;  // the server's time is over
  bool open_ = false;   // rank 0 is inside each()
  std::string list_;
  std::deque<std::size_t> queue_;
  std::map<std::size_t, int> running_;  // piece → rank
  std::map<int, Asked> asked_;          // by rank; one process asks one question at a time
  std::set<int> over_;                  // ranks that have nothing more to do
  std::optional<Failure> failure_;
  std::map<std::size_t, std::string> results_;  // piece → what another process gave for it
  std::function<void()> onDone_;
};

/// Processes of one command, which mpirun started side by side: only the first one speaks.
struct Processes {
  /// Null where this one is alone.
  std::unique_ptr<WorkQueue> queue;
  std::unique_ptr<Progress> progress;

  bool speaks() const { return queue == nullptr || queue->isFirst(); }
};

/// The queue is shared with the others where mpirun has started several. Throws Error that advises what to
/// install when this Estancia cannot join them. To be asked once.
Processes joinProcesses();

}  // namespace estancia
