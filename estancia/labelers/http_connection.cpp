// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/http_connection.hpp"

#include <fmt/format.h>
#include <openssl/x509.h>

#include <algorithm>
#include <string_view>

#include "estancia/core/error.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Less than libcurl allows (100 kB a line, 300 kB in all), where it would speak of a broken connection.
constexpr std::size_t maxHeaders = std::size_t{200} << 10U;  // bytes
constexpr int curlTooLarge = 100;                            // CURLE_TOO_LARGE, known since libcurl 8.6

std::string urlOf(const HttpEndpoint& endpoint) {
  return endpoint.server + endpoint.path;
}

bool isUrl(const std::string& url) {
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parts(curl_url(), &curl_url_cleanup);
  return parts && curl_url_set(parts.get(), CURLUPART_URL, url.c_str(), CURLU_PATH_AS_IS) == CURLUE_OK;
}

std::string secondsOf(milliseconds time) {
  return fmt::format("{} s", std::chrono::duration<double>(time).count());
}

/// One request of a connection.
class Request final : private CurlRequest {
 public:
  Request(const HttpEndpoint& endpoint, const CurlConnections& connections) : endpoint_(endpoint) {
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

  HttpReply post(const std::string& body) {
    set(CURLOPT_POST, 1L);
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
    set(CURLOPT_POSTFIELDS, body.data());
    const CURLcode code = perform();
    if (stopped()) throw Interrupted("stopped while waiting for an answer");
    HttpReply reply;
    if (code != CURLE_OK) {
      explain(code, reply);
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

  void explain(CURLcode code, HttpReply& reply) const {
    if (tooLong_ || code == CURLE_OUT_OF_MEMORY || code == curlTooLarge) {  // the latter: a header
      reply.problem = fmt::format("its answer is longer than {} bytes", endpoint_.maxAnswer);
      reply.hopeless = true;
      return;
    }
    switch (code) {
      case CURLE_COULDNT_RESOLVE_HOST:
      case CURLE_COULDNT_CONNECT:
        reply.problem = "no connection";
        return;
      case CURLE_OPERATION_TIMEDOUT:
        reply.problem = connected_ ? fmt::format("no whole answer within {}", secondsOf(endpoint_.timeout))
                                   : fmt::format("no connection within {}", secondsOf(connectTimeout()));
        return;
      case CURLE_UNSUPPORTED_PROTOCOL:
      case CURLE_WEIRD_SERVER_REPLY:
        reply.problem = "what it answers is no HTTP";
        return;
      case CURLE_SSL_CONNECT_ERROR:
        reply.problem = "no TLS connection; does it speak https?";
        return;
      case CURLE_SSL_CACERT_BADFILE:
        reply.problem = endpoint_.certificates.empty()
                            ? "the system's list of whom to trust cannot be read; install ca-certificates"
                            : "the file `ca` holds no certificates that can be read";
        reply.hopeless = true;
        return;
      case CURLE_PEER_FAILED_VERIFICATION: {
        // libcurl leaves it unspecified when the certificate itself is in order.
        const long reason = info<long>(CURLINFO_SSL_VERIFYRESULT);
        reply.problem = fmt::format(
            "its certificate is refused: {}; for a service of your own, name the certificate that it is "
            "signed with as `ca` in model.toml",
            reason == X509_V_OK || reason == X509_V_ERR_UNSPECIFIED ? "it is made out for another host"
                                                                    : X509_verify_cert_error_string(reason));
        reply.hopeless = true;
        return;
      }
      default:
        reply.problem =
            fmt::format("the connection broke, or was silent for {}", secondsOf(endpoint_.readTimeout));
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

}  // namespace

HttpConnection::HttpConnection(HttpEndpoint endpoint) : endpoint_(std::move(endpoint)) {
  if (!isUrl(urlOf(endpoint_)))
    throw Error(ErrorCode::malformedFile,
                "`url` in model.toml names no server that can be asked; correct it");
}

HttpReply HttpConnection::post(const std::string& body) {
  return Request(endpoint_, connections_).post(body);
}

}  // namespace estancia
