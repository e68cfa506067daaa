#include "estancia/label/label_stream.hpp"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "estancia/core/error.hpp"

namespace estancia {

/// The background thread and its bounded queue.
class LabelStream::Reader {
 public:
  struct Waiting {
    LabelledFrame frame;  ///< without its descriptor
    Prepared input;
  };

  Reader(const Sequence& sequence, const Labeler& labeler, const LabelStreamOptions& options)
      : sequence_(sequence), labeler_(labeler), options_(options), thread_([this] { run(); }) {}

  ~Reader() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// Blocks until a frame is there; nothing at the end. Throws what the thread could not report as a frame's
  /// problem.
  std::optional<Waiting> take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !queue_.empty() || finished_; });
    if (queue_.empty()) {
      if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
      return std::nullopt;
    }
    Waiting prepared = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return prepared;
  }

 private:
  void run() {
    std::exception_ptr failure;
    try {
      for (std::size_t i = options_.first; i < sequence_.size(); ++i)
        if (!put(prepare(i))) break;
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      failure_ = failure;
      finished_ = true;
    }
    changed_.notify_all();
  }

  Waiting prepare(std::size_t i) const {
    Waiting prepared;
    prepared.frame.index = i;
    try {
      if (labeler_.needsImage()) prepared.frame.image = sequence_.image(i);
      prepared.input = labeler_.prepare(prepared.frame.image, sequence_.frame(i).name);
    } catch (const Error& e) {
      if (options_.strict) throw;
      prepared.frame.image.release();
      prepared.frame.problem = e.what();
    }
    return prepared;
  }

  /// Waits for room. False when the stream is being destroyed.
  bool put(Waiting prepared) {
    std::unique_lock lock(mutex_);
    const std::size_t room = std::max<std::size_t>(options_.ahead, 1);
    changed_.wait(lock, [&] { return queue_.size() < room || stopped_; });
    if (stopped_) return false;
    queue_.push_back(std::move(prepared));
    lock.unlock();
    changed_.notify_all();
    return true;
  }

  const Sequence& sequence_;
  const Labeler& labeler_;
  const LabelStreamOptions options_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Waiting> queue_;
  std::exception_ptr failure_;
  bool finished_ = false, stopped_ = false;
  std::thread thread_;  // last: it uses all of the above
};

LabelStream::LabelStream(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options)
    : labeler_(labeler), reader_(std::make_unique<Reader>(sequence, labeler, options)) {}

LabelStream::~LabelStream() = default;

std::optional<LabelledFrame> LabelStream::next() {
  if (!reader_) return std::nullopt;
  try {
    auto prepared = reader_->take();
    if (!prepared) return std::nullopt;
    if (prepared->frame.labelled()) prepared->frame.descriptor = labeler_.infer(prepared->input);
    return std::move(prepared->frame);
  } catch (...) {
    reader_.reset();
    throw;
  }
}

}  // namespace estancia
