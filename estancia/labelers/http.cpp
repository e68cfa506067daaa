// HTTP labeler: a web service that labels images.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <openssl/x509.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <random>
#include <string_view>
#include <thread>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/fetch/curl_request.hpp"
#include "estancia/files/files.hpp"
#include "estancia/files/label_scores.hpp"
#include "estancia/labelers/http_settings.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Less than libcurl allows (100 kB a line, 300 kB in all), where it would speak of a broken connection.
constexpr std::size_t maxHeaders = std::size_t{200} << 10U;  // bytes
constexpr int curlTooLarge = 100;                            // CURLE_TOO_LARGE, known since libcurl 8.6

/// Answer of the service.
struct HttpReply {
  /// 0: no whole answer, see `problem`.
  int status = 0;
  std::string body;
  /// Headers, "" when absent.
  std::string retryAfter, location;
  /// Why there is no answer, one clause.
  std::string problem;
  /// The problem will be the same next time.
  bool hopeless = false;
};

std::string urlOf(const HttpEndpoint& endpoint) {
  return endpoint.server + endpoint.path;
}

std::string secondsOf(milliseconds time) {
  return fmt::format("{} s", std::chrono::duration<double>(time).count());
}

/// A POST request with timeouts that no server can stretch, without proxy and redirects; https is verified.
class HttpRequest final : private CurlRequest {
 public:
  HttpRequest(const HttpEndpoint& endpoint, const CurlConnections& connections) : endpoint_(endpoint) {
    setUrl(urlOf(endpoint_));
    useConnections(connections);
    set(CURLOPT_PATH_AS_IS, 1L);
    set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
    set(CURLOPT_NOPROXY, "*");
    set(CURLOPT_FOLLOWLOCATION, 0L);
    set(CURLOPT_TCP_NODELAY, 1L);
    set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(connectTimeout().count()));
    set(CURLOPT_TIMEOUT_MS, static_cast<long>(endpoint_.timeout.count()));
    if (!endpoint_.certificates.empty()) {
      set(CURLOPT_CAINFO, endpoint_.certificates.c_str());
      set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));  // no other certificates
    }
    for (const auto& [name, value] : endpoint_.headers) {
      const bool empty = value.find_first_not_of(' ') == std::string::npos;
      addHeader(empty ? name + ";" : name + ": " + value);  // "name:" would remove one of libcurl's own
    }
    addHeader("Accept: application/json");
    addHeader("Accept-Encoding: identity");  // a small packed answer could be a large one
    addHeader("Content-Type: " + endpoint_.contentType);
    addHeader("Expect:");  // no asking beforehand, which some servers leave unanswered
  }

  /// Never throws for what the service does. Throws Interrupted, within about a second.
  HttpReply post(const std::string& body) {
    set(CURLOPT_POST, 1L);
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
    set(CURLOPT_POSTFIELDS, body.data());
    const CURLcode code = perform();
    if (stopped()) throw Interrupted("stopped while waiting for an answer");
    HttpReply reply;
    if (code != CURLE_OK) {
      reply.problem = reasonFor(code);
      reply.hopeless =
          isTooLong(code) || code == CURLE_SSL_CACERT_BADFILE || code == CURLE_PEER_FAILED_VERIFICATION;
      return reply;
    }
    reply.status = static_cast<int>(status());
    reply.retryAfter = header("Retry-After");
    reply.location = header("Location");
    reply.body = std::move(body_);
    return reply;
  }

 private:
  bool onConnected() override {
    connected_ = true;
    lastByte_ = Clock::now();
    return true;
  }

  bool onHeader(std::string_view line) override {
    lastByte_ = Clock::now();
    headerBytes_ += line.size();
    tooLong_ = headerBytes_ > maxHeaders;
    return !tooLong_;
  }

  bool onBody(std::string_view bytes) override {
    tooLong_ = bytes.size() > endpoint_.maxAnswer - body_.size();
    if (!tooLong_) body_ += bytes;
    return !tooLong_;
  }

  bool onProgress(curl_off_t received, curl_off_t sent) override {
    if (std::exchange(received_, received) != received || std::exchange(sent_, sent) != sent)
      lastByte_ = Clock::now();
    return !connected_ || Clock::now() - lastByte_ <= endpoint_.readTimeout;
  }

  bool isTooLong(CURLcode code) const {
    return tooLong_ || code == CURLE_OUT_OF_MEMORY || code == curlTooLarge;  // the latter: a header
  }

  std::string reasonFor(CURLcode code) const {
    if (isTooLong(code)) return fmt::format("its answer is longer than {} bytes", endpoint_.maxAnswer);
    switch (code) {
      case CURLE_COULDNT_RESOLVE_HOST:
      case CURLE_COULDNT_CONNECT:
        return "no connection";
      case CURLE_OPERATION_TIMEDOUT:
        return connected_ ? fmt::format("no whole answer within {}", secondsOf(endpoint_.timeout))
                          : fmt::format("no connection within {}", secondsOf(connectTimeout()));
      case CURLE_UNSUPPORTED_PROTOCOL:
      case CURLE_WEIRD_SERVER_REPLY:
        return "what it answers is no HTTP";
      case CURLE_SSL_CONNECT_ERROR:
        return "no TLS connection; does it speak https?";
      case CURLE_SSL_CACERT_BADFILE:
        return endpoint_.certificates.empty()
                   ? "the system's list of whom to trust cannot be read; install ca-certificates"
                   : "the file `ca` holds no certificates that can be read";
      case CURLE_PEER_FAILED_VERIFICATION: {
        // libcurl leaves it unspecified when the certificate itself is in order.
        const long reason = info<long>(CURLINFO_SSL_VERIFYRESULT);
        return fmt::format(
            "its certificate is refused: {}; for a service of your own, name the certificate that it is "
            "signed with as `ca` in model.toml",
            reason == X509_V_OK || reason == X509_V_ERR_UNSPECIFIED ? "it is made out for another host"
                                                                    : X509_verify_cert_error_string(reason));
      }
      default:
        return fmt::format("the connection broke, or was silent for {}", secondsOf(endpoint_.readTimeout));
    }
  }

  milliseconds connectTimeout() const { return std::min(endpoint_.connectTimeout, endpoint_.timeout); }

  const HttpEndpoint& endpoint_;
  std::string body_;
  std::size_t headerBytes_ = 0;
  bool connected_ = false;  // TLS included
  bool tooLong_ = false;
  curl_off_t sent_ = 0, received_ = 0;  // bytes at the last look
  Clock::time_point lastByte_;          // once connected
};

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
  if (status == 401 || status == 403) return "; check the key in `headers` and what it may do";
  return status == 404 || status == 405 || status == 410 ? "; check `url`" : "";
}

/// Labels images by an HTTP service, several requests at once. Invariant: each lane has one connection and is
/// used by one thread; `mutex_` guards the turn of the next request and the failure that stops all lanes.
/// Life cycle: lanes are kept from batch to batch, with their connections.
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
      estancia::fail(ErrorCode::invalidInput, "{}: the image {} cannot be packed for sending", source_,
                     frame);
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
  /// A connection that is kept open between requests, and the dice for its waits.
  struct Lane {
    explicit Lane(std::uint64_t seed) : random(seed) {}
    const CurlConnections connections;
    std::mt19937_64 random;
  };

  void requireUrl() const {
    const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parts(curl_url(), &curl_url_cleanup);
    if (!parts || curl_url_set(parts.get(), CURLUPART_URL, urlOf(settings_.endpoint).c_str(),
                               CURLU_PATH_AS_IS) != CURLUE_OK)
      throw Error(ErrorCode::malformedFile,
                  "`url` in model.toml names no server that can be asked; correct it");
  }

  std::vector<Outcome> askAll(std::span<const Prepared> batch) {
    const std::size_t count = std::min(settings_.parallel, batch.size());
    if (lanes_.size() < count) requireUrl();
    while (lanes_.size() < count) lanes_.push_back(std::make_unique<Lane>(settings_.seed + lanes_.size()));
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
      HttpReply reply = HttpRequest(settings_.endpoint, lane.connections).post(body);
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
