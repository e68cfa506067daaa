// SPDX-License-Identifier: Apache-2.0
#include "estancia/label/label_stream.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <exception>
#include <thread>
#include <utility>

#include "estancia/core/bytes.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/options.hpp"

namespace estancia {
namespace {

/// The words in `bytes`, or nothing when they are none.
std::optional<std::vector<LabelProbability>> wordsIn(std::string_view bytes) try {
  std::vector<LabelProbability> words;
  for (ByteReader reader(bytes, "cached words", "label again"); reader.remaining() > 0;) {
    const auto probability = reader.number<float>();
    words.push_back({reader.text(), probability});
    if (words.back().label.empty() || !(probability >= 0 && probability <= 1)) return std::nullopt;
  }
  return words;
} catch (const Error&) {  // cut off
  return std::nullopt;
}

/// The values; if the labeler discovers words, those that are not 0 by name: numbers differ from run to run.
std::string packWords(DescriptorView descriptor, const Labeler& labeler) {
  if (!labeler.discovers())
    return {reinterpret_cast<const char*>(descriptor.data()), descriptor.size_bytes()};
  ByteWriter words;
  for (std::size_t i = 0; i < descriptor.size(); ++i) {
    if (descriptor[i] == 0) continue;
    words.number(descriptor[i]);
    words.text(labeler.vocabulary()[i]);
  }
  return words.bytes();
}

/// Whether `bytes` are what packWords() makes for this labeler. Safe to call beside the labeler's work.
bool holdsWords(std::string_view bytes, const Labeler& labeler) {
  if (labeler.discovers()) return wordsIn(bytes).has_value();
  return bytes.size() == labeler.vocabulary().size() * sizeof(float);
}

/// Back again; `bytes` must be sound.
LexicalDescriptor unpackWords(std::string_view bytes, Labeler& labeler) {
  if (labeler.discovers()) return labeler.adopt(wordsIn(bytes).value());
  LexicalDescriptor values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

/// The labelers that really look at frames: the members of an ensemble, or the labeler itself.
std::vector<Labeler*> partsOf(Labeler& labeler) {
  auto parts = labeler.members();
  return parts.empty() ? std::vector<Labeler*>{&labeler} : parts;
}

/// What one part contains or needs.
struct Part {
  std::optional<std::string> remembered;  ///< from the cache
  Prepared input;                         ///< otherwise
};

struct Waiting {
  LabeledFrame frame;  ///< without its descriptor
  std::string fingerprint;
  std::vector<Part> parts;
};

/// Raw pixels identify an image where its file does not.
std::string fingerprintOf(const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  return sha256({reinterpret_cast<const char*>(whole.data), whole.total() * whole.elemSize()}) + " pixels " +
         std::to_string(whole.cols) + "x" + std::to_string(whole.rows);
}

}  // namespace

/// The background threads. Each takes the next frame; they hand them over in order. Invariant: at most
/// `room_` frames are read ahead of the one to give next; `mutex_` guards everything that follows it. Life
/// cycle: threads start in the constructor and end, also with an unread rest, in the destructor; the first
/// failure, by frame number, is thrown when its frame is due.
class LabelStream::Reader {
 public:
  Reader(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options)
      : sequence_(sequence),
        parts_(partsOf(labeler)),
        options_(options),
        room_(options.ahead),
        nextToRead_(options.first),
        nextToGive_(options.first) {
    for (Labeler* part : parts_) {
      needsImage_ = needsImage_ || part->needsImage();
      keys_.push_back(part->cacheKey());
    }
    const std::size_t threads = std::min(options.readers, room_);
    threads_.reserve(threads);
    try {
      for (std::size_t t = 0; t < threads; ++t) threads_.emplace_back([this] { run(); });
    } catch (const std::exception&) {
      if (threads_.empty()) throw;  // else those that are there do the work
    }
  }

  ~Reader() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    drained_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// Blocks until the next frame is there; nothing at the end. Throws what is no frame's problem.
  std::optional<Waiting> take() {
    std::unique_lock lock(mutex_);
    // Frames before the one that failed are in other threads' hands and will come.
    arrived_.wait(lock, [this] {
      return ready_.contains(nextToGive_) || (failed_ && nextToGive_ >= failedAt_) ||
             nextToGive_ >= sequence_.size();
    });
    const auto found = ready_.find(nextToGive_);
    if (found == ready_.end()) {
      if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
      return std::nullopt;
    }
    Waiting waiting = std::move(found->second);
    ready_.erase(found);
    ++nextToGive_;
    // Not for every frame: to wake a thread costs as much as a small network.
    const bool halfEmpty = nextToGive_ + room_ - nextToRead_ >= std::max<std::size_t>(room_ / 2, 1);
    lock.unlock();
    if (halfEmpty) drained_.notify_all();
    return waiting;
  }

 private:
  void run() {
    for (;;) {
      std::size_t i = 0;
      {
        std::unique_lock lock(mutex_);
        drained_.wait(lock, [this] { return stopped_ || failed_ || nextToRead_ < nextToGive_ + room_; });
        if (stopped_ || failed_ || nextToRead_ >= sequence_.size()) return;
        i = nextToRead_++;
      }
      std::optional<Waiting> waiting;
      std::exception_ptr failure;
      try {
        waiting = read(i);
      } catch (...) {
        failure = std::current_exception();
      }
      bool awaited = false;
      {
        const std::lock_guard lock(mutex_);
        if (waiting) ready_.emplace(i, std::move(*waiting));
        // The first frame that fails is reported, whichever thread comes first.
        if (failure && (!failed_ || i < failedAt_)) {
          failure_ = failure;
          failedAt_ = i;
          failed_ = true;
        }
        awaited = failed_ || i == nextToGive_;
      }
      if (awaited) arrived_.notify_one();
      if (failure) drained_.notify_all();
    }
  }

  Waiting read(std::size_t i) const {
    Waiting waiting;
    waiting.frame.index = i;
    waiting.parts.resize(parts_.size());
    try {
      if (options_.cache != nullptr && needsImage_) waiting.fingerprint = sequence_.fingerprint(i);
      recall(waiting);
      const std::vector<cv::Mat> reduced = look(waiting);
      if (options_.cache != nullptr && looksAtImage(waiting)) identify(waiting);
      for (std::size_t p = 0; p < parts_.size(); ++p)
        if (Part& part = waiting.parts[p]; !part.remembered)
          part.input = parts_[p]->prepare(reduced[p].empty() ? waiting.frame.image : reduced[p],
                                          sequence_.frame(i).name);
    } catch (...) {
      const Error failure = frameFailure(sequence_.frame(i).name);
      if (options_.strict) throw failure;
      waiting.frame.image.release();
      waiting.frame.problem = failure.what();
    }
    return waiting;
  }

  /// Decodes the image for the missing words: whole into the frame, and reduced for parts that take it so.
  std::vector<cv::Mat> look(Waiting& waiting) const {
    const std::size_t i = waiting.frame.index;
    // Images without a file's fingerprint are identified by their pixels (identify()).
    bool whole = options_.cache != nullptr && waiting.fingerprint.empty() && looksAtImage(waiting);
    std::vector<cv::Mat> reduced(parts_.size());
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      if (waiting.parts[p].remembered || !parts_[p]->needsImage()) continue;
      if (const int side = parts_[p]->imageSide(); side > 0)
        reduced[p] = sequence_.reducedImage(i, side);
      else
        whole = true;
    }
    if (whole) waiting.frame.image = sequence_.image(i);
    return reduced;
  }

  /// Whether the image must be decoded for the words that are still missing.
  bool looksAtImage(const Waiting& waiting) const {
    for (std::size_t p = 0; p < parts_.size(); ++p)
      if (parts_[p]->needsImage() && !waiting.parts[p].remembered) return true;
    return false;
  }

  /// Sets the fingerprint of a decoded image: that of its pixels if its file gives none, and none if the file
  /// has just been changed, since it is unknown which version was read.
  void identify(Waiting& waiting) const {
    if (waiting.fingerprint.empty()) {
      waiting.fingerprint = fingerprintOf(waiting.frame.image);
      recall(waiting);
    } else if (sequence_.fingerprint(waiting.frame.index) != waiting.fingerprint) {
      waiting.fingerprint.clear();
    }
  }

  void recall(Waiting& waiting) const {
    if (waiting.fingerprint.empty()) return;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      if (!parts_[p]->needsImage()) continue;
      auto& words = waiting.parts[p].remembered;
      words = options_.cache->find(keys_[p], waiting.fingerprint);
      if (words && !holdsWords(*words, *parts_[p])) words.reset();
    }
  }

  const Sequence& sequence_;
  const std::vector<Labeler*> parts_;
  const LabelStreamOptions options_;
  const std::size_t room_;
  std::vector<std::string> keys_;
  bool needsImage_ = false;
  std::mutex mutex_;
  std::condition_variable arrived_;  ///< the next frame to give, or a failure
  std::condition_variable drained_;  ///< there is room for more
  std::map<std::size_t, Waiting> ready_;
  std::size_t nextToRead_, nextToGive_;
  std::exception_ptr failure_;
  std::size_t failedAt_ = 0;
  bool failed_ = false, stopped_ = false;
  std::vector<std::thread> threads_;  // last: they use all of the above
};

/// The caller's side: batches for each part, words into the cache, answers put together.
class LabelStream::Inference {
 public:
  Inference(Labeler& labeler, const LabelStreamOptions& options)
      : labeler_(labeler), parts_(partsOf(labeler)), options_(options) {
    for (Labeler* part : parts_) keys_.push_back(part->cacheKey());
  }

  std::optional<LabeledFrame> next(Reader& reader) {
    if (done_.empty() && !failure_) fill(reader);
    if (done_.empty()) {
      if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
      return std::nullopt;
    }
    LabeledFrame frame = std::move(done_.front());
    done_.pop_front();
    return frame;
  }

 private:
  /// The next frames: as many as one batch, or one that needs no inference.
  void fill(Reader& reader) {
    std::vector<Waiting> frames;
    std::size_t toInfer = 0;
    try {
      while (toInfer < batch_ && frames.size() < options_.ahead) {
        auto waiting = reader.take();
        if (!waiting) break;
        // Only now: a labeler may open its network when first asked.
        if (needsInference(*waiting) && ++toInfer == 1)
          for (Labeler* part : parts_) batch_ = std::max(batch_, part->batchSize());
        frames.push_back(std::move(*waiting));
        if (toInfer == 0) break;
      }
    } catch (...) {
      failure_ = std::current_exception();  // after the frames before it
    }
    std::vector<std::vector<LexicalDescriptor>> answers(frames.size(),
                                                        std::vector<LexicalDescriptor>(parts_.size()));
    for (std::size_t p = 0; p < parts_.size(); ++p) ask(p, frames, answers);
    for (std::size_t f = 0; f < frames.size(); ++f) {
      LabeledFrame& frame = frames[f].frame;
      if (frame.labeled()) {
        frame.remembered = isRemembered(frames[f]);
        frame.descriptor =
            labeler_.members().empty() ? std::move(answers[f][0]) : labeler_.combine(answers[f]);
      } else if (options_.strict) {
        failure_ = std::make_exception_ptr(FrameError(frame.problem));
        break;
      }
      done_.push_back(std::move(frame));
    }
  }

  static bool needsInference(const Waiting& waiting) {
    return waiting.frame.labeled() && std::any_of(waiting.parts.begin(), waiting.parts.end(),
                                                  [](const Part& part) { return !part.remembered; });
  }

  /// Whether the cache gave what would else have needed a look at the image.
  bool isRemembered(const Waiting& waiting) const {
    bool some = false;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      if (!parts_[p]->needsImage()) continue;
      if (!waiting.parts[p].remembered) return false;
      some = true;
    }
    return some;
  }

  /// The answers of one part to all frames, in their order, since new words are numbered as they come.
  void ask(std::size_t p, std::vector<Waiting>& frames,
           std::vector<std::vector<LexicalDescriptor>>& answers) {
    Labeler& part = *parts_[p];
    std::vector<std::size_t> asked;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      if (!frames[f].frame.labeled()) continue;
      if (const auto& words = frames[f].parts[p].remembered) {
        if (part.discovers()) infer(p, frames, std::exchange(asked, {}), answers);
        answers[f][p] = unpackWords(*words, part);
      } else {
        asked.push_back(f);
      }
    }
    infer(p, frames, asked, answers);
  }

  void infer(std::size_t p, std::vector<Waiting>& frames, const std::vector<std::size_t>& asked,
             std::vector<std::vector<LexicalDescriptor>>& answers) {
    if (asked.empty()) return;
    Labeler& part = *parts_[p];
    std::vector<Prepared> batch;
    for (const std::size_t f : asked) batch.push_back(std::move(frames[f].parts[p].input));
    const auto remember = [&](const std::vector<LabelResult>& results) {
      for (std::size_t b = 0; b < results.size(); ++b)
        if (const Waiting& waiting = frames[asked[b]]; options_.cache != nullptr &&
                                                       !results[b].descriptor.empty() &&
                                                       !waiting.fingerprint.empty() && part.needsImage())
          options_.cache->put(keys_[p], waiting.fingerprint, packWords(results[b].descriptor, part));
    };
    try {
      std::vector<LabelResult> results = part.inferBatch(batch);
      remember(results);
      for (std::size_t b = 0; b < results.size(); ++b) {
        frames[asked[b]].frame.problem = std::move(results[b].problem);
        answers[asked[b]][p] = std::move(results[b].descriptor);
      }
    } catch (const BatchError& e) {  // what was paid for is kept
      remember(e.results);
      throw;
    }
  }

  Labeler& labeler_;
  const std::vector<Labeler*> parts_;
  const LabelStreamOptions options_;
  std::vector<std::string> keys_;
  std::size_t batch_ = 1;
  std::deque<LabeledFrame> done_;
  std::exception_ptr failure_;
};

OptionGroup declare(LabelStreamOptions& options) {
  OptionGroup group("label-stream", "How a sequence is labeled.");
  group.add("first", &options.first, "The first frame to label.").range(0).unit("frames");
  group.add("strict", &options.strict, "Stop at an unreadable frame instead of skipping it.")
      .why("A data set of which nothing may be missing.");
  return group;
}

LabelStream::LabelStream(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options) {
  validate(options);
  if (options.ahead == 0 || options.readers == 0)
    fail(ErrorCode::invalidOption, "label-stream.{} is 0; give at least 1",
         options.ahead == 0 ? "ahead" : "readers");
  inference_ = std::make_unique<Inference>(labeler, options);
  reader_ = std::make_unique<Reader>(sequence, labeler, options);
}

LabelStream::~LabelStream() = default;

std::optional<LabeledFrame> LabelStream::next() {
  if (!reader_) return std::nullopt;
  try {
    return inference_->next(*reader_);
  } catch (...) {
    reader_.reset();
    throw;
  }
}

DescriptorSequence record(const Sequence& sequence, Labeler& labeler, const LabelStreamOptions& options,
                          const std::function<void(const LabeledFrame&)>& watch) {
  std::vector<Frame> frames;
  std::vector<LexicalDescriptor> words;
  std::string problem;  // the first
  LabelStream stream(sequence, labeler, options);
  while (auto frame = stream.next()) {
    if (watch) watch(*frame);
    if (problem.empty()) problem = frame->problem;
    if (!frame->labeled()) continue;
    frames.push_back(sequence.frame(frame->index));
    words.push_back(std::move(frame->descriptor));
  }
  if (frames.empty())
    fail(ErrorCode::labelerFailure, "{}: not one of its frames could be labeled{}", sequence.name(),
         problem.empty() ? "" : "; " + problem);
  DescriptorSequence recording{labeler.vocabulary(), labeler.identity(), std::move(frames),
                               DescriptorMatrix(labeler.vocabulary().size())};
  recording.descriptors.reserve(words.size());
  for (LexicalDescriptor& row : words) {
    row.resize(recording.vocabulary.size());  // words that were found later
    recording.descriptors.append(row);
    LexicalDescriptor().swap(row);
  }
  return recording;
}

DescriptorSequence labelAll(const Sequence& sequence, Labeler& labeler, const std::string& what,
                            const LabelStreamOptions& options, Progress& progress,
                            const std::function<void(const LabeledFrame&)>& watch) {
  progress.begin(what, sequence.size());
  DescriptorSequence recording = record(sequence, labeler, options, [&](const LabeledFrame& frame) {
    if (watch) watch(frame);
    progress.advance();
    if (interrupted())
      throw Interrupted(options.cache != nullptr
                            ? "stopped; what is labeled is kept, the same command goes on from there"
                            : "stopped; without the cache nothing is kept, the same command begins anew");
  });
  progress.end();
  return recording;
}

}  // namespace estancia
