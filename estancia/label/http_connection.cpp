// SPDX-License-Identifier: Apache-2.0
#include "estancia/label/http_connection.hpp"

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
constexpr std::size_t kMaxHeaders = std::size_t{200} << 10U;  // bytes
constexpr int kTooLarge = 100;                                // CURLE_TOO_LARGE, known since libcurl 8.6

bool isUrl(const std::string& url) {
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parts(curl_url(), &curl_url_cleanup);
  return parts && curl_url_set(parts.get(), CURLUPART_URL, url.c_str(), CURLU_PATH_AS_IS) == CURLUE_OK;
}

std::string secondsOf(milliseconds time) {
  return fmt::format("{} s", std::chrono::duration<double>(time).count());
}

}  // namespace

HttpConnection::HttpConnection(HttpEndpoint endpoint) : endpoint_(std::move(endpoint)) {
  const std::string url = endpoint_.server + endpoint_.path;
  if (!isUrl(url))
    throw Error(ErrorCode::malformedFile,
                "`url` in model.toml names no server that can be asked; correct it");
  setUrl(url);
  set(CURLOPT_PATH_AS_IS, 1L);
  set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  set(CURLOPT_NOPROXY, "*");
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_TCP_NODELAY, 1L);
  set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(connectTimeout().count()));
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(endpoint_.timeout.count()));
  if (!endpoint_.certificates.empty()) {
    set(CURLOPT_CAINFO, endpoint_.certificates.c_str());
    set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));  // nobody else
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

HttpReply HttpConnection::post(const std::string& body) {
  answer_ = {};
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
  reply.body = std::move(answer_.body);
  return reply;
}

bool HttpConnection::onConnected() {
  answer_.connected = true;
  answer_.lastByte = Clock::now();
  return true;
}

bool HttpConnection::onHeader(std::string_view line) {
  answer_.lastByte = Clock::now();
  answer_.headerBytes += line.size();
  answer_.tooLong = answer_.headerBytes > kMaxHeaders;
  return !answer_.tooLong;
}

bool HttpConnection::onBody(std::string_view bytes) {
  answer_.tooLong = bytes.size() > endpoint_.maxAnswer - answer_.body.size();
  if (!answer_.tooLong) answer_.body += bytes;
  return !answer_.tooLong;
}

bool HttpConnection::onProgress(curl_off_t received, curl_off_t sent) {
  if (std::exchange(answer_.received, received) != received || std::exchange(answer_.sent, sent) != sent)
    answer_.lastByte = Clock::now();
  return !answer_.connected || Clock::now() - answer_.lastByte <= endpoint_.readTimeout;
}

void HttpConnection::explain(CURLcode code, HttpReply& reply) const {
  if (answer_.tooLong || code == CURLE_OUT_OF_MEMORY || code == kTooLarge) {  // the latter: a header
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
      reply.problem = answer_.connected
                          ? fmt::format("no whole answer within {}", secondsOf(endpoint_.timeout))
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

}  // namespace estancia
