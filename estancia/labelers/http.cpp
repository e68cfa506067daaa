// HTTP labeler: a web service that labels images.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/label_scores.hpp"
#include "estancia/labelers/black_box.hpp"
#include "estancia/labelers/http_connection.hpp"
#include "estancia/labelers/http_settings.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Result of a service for one image.
struct Outcome {
  std::vector<LabelProbability> words = {};
  /// Why this image failed.
  std::string problem = {};
  /// Failure of the service: the work cannot go on.
  std::optional<Error> failure = {};
  bool answered = false;
};

/// Retry-After: seconds, or a date (RFC 9110, 10.2.3).
std::optional<milliseconds> readRetryAfter(const std::string& text) {
  long seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (error == std::errc() && end == text.data() + text.size() && seconds >= 0)
    return milliseconds(1000 * std::min(seconds, 10'000'000L));
  std::tm date{};
  if (strptime(text.c_str(), "%a, %d %b %Y %H:%M:%S GMT", &date) == nullptr) return std::nullopt;
  const double wait = std::difftime(timegm(&date), std::time(nullptr));
  return milliseconds(static_cast<long>(1000 * std::clamp(wait, 0.0, 1e7)));
}

std::string adviceFor(int status) {
  switch (status) {
    case 401:
    case 403:
      return "; check the key in `headers` and what it may do";
    case 404:
    case 405:
    case 410:
      return "; check `url`";
    default:
      return "";
  }
}

class HttpLabeler final : public Labeler {
 public:
  explicit HttpLabeler(const ModelSpec& spec)
      : settings_(readHttpSettings(spec)),
        source_(fmt::format("model {}: {}", spec.name, settings_.url)),
        book_(wordBook(spec)) {}

  const Vocabulary& vocabulary() const override { return book_.vocabulary(); }
  bool discovers() const override { return book_.discovers(); }
  LexicalDescriptor adopt(std::span<const LabelProbability> words) override {
    return describe(book_, {words.begin(), words.end()}, 0, source_);
  }
  std::string identity() const override { return settings_.identity; }
  std::size_t batchSize() const override { return settings_.parallel; }

  /// The whole body of the request.
  Prepared prepare(const cv::Mat& bgr, const std::string& frame) const override {
    try {
      const std::string body = requestBody(settings_, bgr);
      const cv::Mat bytes(1, static_cast<int>(body.size()), CV_8U, const_cast<char*>(body.data()));
      return {bytes.clone(), frame, {}};
    } catch (const cv::Exception&) {
      throw Error(ErrorCode::invalidInput,
                  fmt::format("{}: the image {} cannot be packed for sending", source_, frame));
    }
  }

  LexicalDescriptor infer(const Prepared& prepared) override {
    auto result = std::move(inferBatch({&prepared, 1})[0]);
    if (!result.problem.empty()) throw FrameError(result.problem);
    return std::move(result.descriptor);
  }

  std::vector<LabelResult> inferBatch(std::span<const Prepared> batch) override {
    auto outcomes = askAll(batch);
    std::optional<Error> failure;
    bool stopped = false;
    std::vector<LabelResult> results;
    for (Outcome& outcome : outcomes) try {  // in order: who discovers a word first is no race
        if (outcome.failure && !failure) failure = outcome.failure;
        if (!outcome.problem.empty()) throw FrameError(outcome.problem);
        if (!outcome.answered) {
          stopped = true;
          results.emplace_back();
          continue;
        }
        results.push_back({describe(book_, std::move(outcome.words), settings_.answer.best, source_), ""});
      } catch (const FrameError& e) {
        results.push_back({{}, e.what()});
      } catch (const Error&) {
        throw;
      } catch (...) {
        results.push_back({{}, frameFailure(batch[results.size()].frame).what()});
      }
    if (failure) throw BatchError(*failure, std::move(results));  // what was paid for is kept
    if (stopped) throw Interrupted("stopped while waiting for an answer");
    return results;
  }

 private:
  /// A connection and the dice for its waits.
  struct Lane {
    Lane(const HttpEndpoint& endpoint, std::uint64_t seed) : connection(endpoint), random(seed) {}
    HttpConnection connection;
    std::mt19937_64 random;
  };

  std::vector<Outcome> askAll(std::span<const Prepared> batch) {
    const std::size_t count = std::min(settings_.parallel, batch.size());
    while (lanes_.size() < count)
      lanes_.push_back(std::make_unique<Lane>(settings_.endpoint, settings_.seed + lanes_.size()));
    std::vector<Outcome> outcomes(batch.size());
    failed_ = false;
    std::atomic<std::size_t> next{0};
    const auto work = [&](Lane& lane) {
      for (std::size_t i; !failed_ && (i = next++) < batch.size();) {
        outcomes[i] = ask(lane, batch[i]);
        if (outcomes[i].failure) fail();
      }
    };
    std::vector<std::jthread> others;
    for (std::size_t k = 1; k < count; ++k) others.emplace_back(work, std::ref(*lanes_[k]));
    if (count > 0) work(*lanes_[0]);
    return others.clear(), outcomes;
  }

  /// Asks until there is an answer or a failure that will not pass; neither when the work ends before.
  Outcome ask(Lane& lane, const Prepared& prepared) try {
    const std::string body(prepared.input.ptr<char>(), prepared.input.total());
    for (int attempt = 1;; ++attempt) {
      if (!waitUntil(nextTurn())) return {};
      HttpReply reply = lane.connection.post(body);
      // Redact secrets (a service may echo the key) before truncating for a message.
      reply.body = withoutSecrets(reply.body, settings_.secrets);
      reply.location = withoutSecrets(reply.location, settings_.secrets);
      if (reply.status / 100 == 2) return read(reply);
      if (!mayPass(reply)) return judge(reply);
      const std::string reason = reasonOf(reply);
      if (attempt >= settings_.attempts)
        return failed(reply,
                      fmt::format("{}, after {} attempts for {}; try later: what is labeled stays so", reason,
                                  attempt, prepared.frame.empty() ? "an image" : prepared.frame));
      auto wait = backoff(lane, attempt);
      if (const auto asked = readRetryAfter(reply.retryAfter)) {
        if (*asked > settings_.maxWait)
          return failed(reply, fmt::format("{}: it asks to wait {} s, more than `max_wait` ({} s); try later",
                                           reason, asked->count() / 1000, settings_.maxWait.count() / 1000));
        wait = std::max(wait, *asked);
      }
      if (!waitUntil(Clock::now() + wait)) return {};
    }
  } catch (const Interrupted&) {
    return {};
  } catch (const Error& e) {
    return {.failure = e};
  } catch (...) {
    return {.problem = frameFailure(prepared.frame).what()};
  }

  Outcome read(const HttpReply& reply) const {
    io::Answer answer = io::readAnswer(reply.body, settings_.answer.format, source_);
    if (!answer.error.empty()) return {.problem = message(answer.error)};
    return {.words = std::move(answer.words), .answered = true};
  }

  static bool mayPass(const HttpReply& reply) {
    if (reply.status == 0) return !reply.hopeless;
    return reply.status == 408 || reply.status == 429 || reply.status >= 500;
  }

  Outcome judge(const HttpReply& reply) const {
    const int status = reply.status;
    if (status == 400 || status == 413 || status == 415 || status == 422)
      return {.problem = message(fmt::format("refuses the image: {}", reasonOf(reply)))};
    if (status / 100 == 3)
      return failed(
          reply, fmt::format("HTTP {}: it has moved to {}; no redirect is followed, so correct `url`", status,
                             io::printable(reply.location.substr(0, 200))));
    return failed(reply, reasonOf(reply) + adviceFor(status));
  }

  Outcome failed(const HttpReply& reply, const std::string& what) const {
    return {.failure =
                Error(reply.status == 0 ? ErrorCode::network : ErrorCode::serverFailure, message(what))};
  }

  static std::string reasonOf(const HttpReply& reply) {
    if (reply.status == 0) return reply.problem;
    constexpr std::size_t maxText = 120;
    const std::string text = io::printable(std::string_view(reply.body).substr(0, maxText));
    return fmt::format("HTTP {}{}{}", reply.status, text.empty() ? "" : ": ", text);
  }

  std::string message(const std::string& what) const { return fmt::format("{}: {}", source_, what); }

  /// Doubling, with up to half of it taken off at random, so that the lanes do not come back together.
  milliseconds backoff(Lane& lane, int attempt) const {
    const double full = std::min(static_cast<double>(settings_.backoff.count()) * std::exp2(attempt - 1),
                                 static_cast<double>(settings_.maxWait.count()));
    return milliseconds(std::llround(full * std::uniform_real_distribution<>(0.5, 1)(lane.random)));
  }

  /// When the next request may go: `rate` a second over all lanes.
  Clock::time_point nextTurn() {
    if (settings_.rate == 0) return Clock::now();
    const std::lock_guard lock(mutex_);
    const auto turn = std::max(Clock::now(), nextTurn_);
    nextTurn_ =
        turn + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / settings_.rate));
    return turn;
  }

  /// False when another lane has failed meanwhile, or the user wants to stop.
  bool waitUntil(Clock::time_point time) {
    constexpr milliseconds betweenLooks{200};
    std::unique_lock lock(mutex_);
    while (!failed_ && !interrupted()) {
      const auto now = Clock::now();
      if (now >= time) return true;
      changed_.wait_until(lock, std::min(time, now + betweenLooks));
    }
    return false;
  }

  void fail() {
    {
      const std::lock_guard lock(mutex_);
      failed_ = true;
    }
    changed_.notify_all();
  }

  HttpSettings settings_;
  std::string source_;
  io::WordBook book_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<bool> failed_{false};
  Clock::time_point nextTurn_{};
};

}  // namespace

std::unique_ptr<Labeler> openHttp(const ModelSpec& spec) {
  return std::make_unique<HttpLabeler>(spec);
}

}  // namespace estancia
