#include "estancia/label/http_connection.hpp"

#include <curl/curl.h>
#include <fmt/format.h>
#include <openssl/x509.h>

#include <algorithm>
#include <exception>
#include <string_view>

#include "estancia/core/curl_handle.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/no_sigpipe.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Less than libcurl allows (100 kB a line, 300 kB in all), where it would speak of a broken connection.
constexpr std::size_t kMostHeaders = std::size_t{200} << 10U;  // bytes
constexpr int kTooLarge = 100;                                 // CURLE_TOO_LARGE, known since libcurl 8.6

bool canBeAsked(const std::string& url) {
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parts(curl_url(), &curl_url_cleanup);
  return parts && curl_url_set(parts.get(), CURLUPART_URL, url.c_str(), CURLU_PATH_AS_IS) == CURLUE_OK;
}

std::string secondsOf(milliseconds time) {
  return fmt::format("{} s", std::chrono::duration<double>(time).count());
}

}  // namespace

class HttpConnection::Implementation {
 public:
  explicit Implementation(HttpEndpoint endpoint)
      : endpoint_(std::move(endpoint)), curl_(makeCurlHandle()), headers_(nullptr, &curl_slist_free_all) {
    const std::string url = endpoint_.server + endpoint_.path;
    if (!canBeAsked(url)) throw Error("`url` in model.toml names no server that can be asked; correct it");
    set(CURLOPT_URL, url.c_str());
    set(CURLOPT_PATH_AS_IS, 1L);
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
    set(CURLOPT_NOPROXY, "*");
    set(CURLOPT_FOLLOWLOCATION, 0L);
    set(CURLOPT_USERAGENT, "estancia");
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_TCP_NODELAY, 1L);
    set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(connectTimeout().count()));
    set(CURLOPT_TIMEOUT_MS, static_cast<long>(endpoint_.timeout.count()));
    if (!endpoint_.certificates.empty()) {
      set(CURLOPT_CAINFO, endpoint_.certificates.c_str());
      set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));  // nobody else
    }
    for (const auto& [name, value] : endpoint_.headers) addHeader(name, value);
    addHeader("Accept", "application/json");
    addHeader("Accept-Encoding", "identity");  // a small packed answer could be a large one
    addHeader("Content-Type", endpoint_.contentType);
    append("Expect:");  // no asking beforehand, which some servers leave unanswered
    set(CURLOPT_HTTPHEADER, headers_.get());
    set(CURLOPT_PREREQFUNCTION, &Implementation::onConnected);
    set(CURLOPT_PREREQDATA, this);
    set(CURLOPT_HEADERFUNCTION, &Implementation::onHeader);
    set(CURLOPT_HEADERDATA, this);
    set(CURLOPT_WRITEFUNCTION, &Implementation::onBody);
    set(CURLOPT_WRITEDATA, this);
    set(CURLOPT_NOPROGRESS, 0L);
    set(CURLOPT_XFERINFOFUNCTION, &Implementation::onProgress);
    set(CURLOPT_XFERINFODATA, this);
  }

  ~Implementation() {
    const NoSigpipe quiet;  // it may say goodbye
    curl_.reset();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  HttpReply post(const std::string& body) {
    request_ = {};
    set(CURLOPT_POST, 1L);
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
    set(CURLOPT_POSTFIELDS, body.data());
    const NoSigpipe quiet;
    const CURLcode code = curl_easy_perform(curl_.get());
    if (request_.failure) std::rethrow_exception(request_.failure);
    if (request_.stopped) throw Interrupted("stopped while waiting for an answer");
    HttpReply reply;
    if (code != CURLE_OK) {
      explain(code, reply);
      return reply;
    }
    reply.status = static_cast<int>(info<long>(CURLINFO_RESPONSE_CODE));
    reply.retryAfter = header("Retry-After");
    reply.location = header("Location");
    reply.body = std::move(request_.body);
    return reply;
  }

 private:
  /// What is known of the request under way.
  struct Request {
    std::string body;                   ///< of the answer
    std::size_t headerBytes = 0;        ///< of the answer
    bool connected = false;             ///< TLS included
    bool tooLong = false;               ///< the answer
    bool stopped = false;               ///< by the user
    curl_off_t sent = 0, received = 0;  ///< bytes at the last look
    Clock::time_point lastByte;         ///< once connected
    std::exception_ptr failure;         ///< must not pass through C
  };

  template <class Value>
  void set(CURLoption option, Value value) {
    if (curl_easy_setopt(curl_.get(), option, value) != CURLE_OK)
      throw Error("libcurl lacks something that web services need; install a complete one");
  }

  template <class Value>
  Value info(CURLINFO what) const {
    Value value{};
    curl_easy_getinfo(curl_.get(), what, &value);
    return value;
  }

  void addHeader(const std::string& name, const std::string& value) {
    const bool empty = value.find_first_not_of(' ') == std::string::npos;
    append(empty ? name + ";" : name + ": " + value);  // "name:" would remove one of libcurl's own
  }

  void append(const std::string& line) {
    curl_slist* longer = curl_slist_append(headers_.get(), line.c_str());
    if (longer == nullptr) throw Error("no memory left for the headers of a request");
    static_cast<void>(headers_.release());  // a part of the longer one
    headers_.reset(longer);
  }

  std::string header(const char* name) const {
    curl_header* found = nullptr;
    return curl_easy_header(curl_.get(), name, 0, CURLH_HEADER, -1, &found) == CURLHE_OK ? found->value : "";
  }

  milliseconds connectTimeout() const { return std::min(endpoint_.connectTimeout, endpoint_.timeout); }

  void heard() { request_.lastByte = Clock::now(); }

  static int onConnected(void* self, char*, char*, int, int) {
    auto& mine = *static_cast<Implementation*>(self);
    mine.request_.connected = true;
    mine.heard();
    return CURL_PREREQFUNC_OK;
  }

  static std::size_t onHeader(char*, std::size_t one, std::size_t count, void* self) {
    auto& mine = *static_cast<Implementation*>(self);
    mine.heard();
    mine.request_.headerBytes += one * count;
    mine.request_.tooLong = mine.request_.headerBytes > kMostHeaders;
    return mine.request_.tooLong ? CURL_WRITEFUNC_ERROR : one * count;
  }

  static std::size_t onBody(char* data, std::size_t one, std::size_t count, void* self) {
    auto& mine = *static_cast<Implementation*>(self);
    const std::string_view bytes(data, one * count);
    try {
      mine.request_.tooLong = bytes.size() > mine.endpoint_.longestAnswer - mine.request_.body.size();
      if (mine.request_.tooLong) return CURL_WRITEFUNC_ERROR;
      mine.request_.body += bytes;
      return bytes.size();
    } catch (...) {
      mine.request_.failure = std::current_exception();
      return CURL_WRITEFUNC_ERROR;
    }
  }

  /// Asked at least once a second. Not 0 ends the request.
  static int onProgress(void* self, curl_off_t, curl_off_t received, curl_off_t, curl_off_t sent) {
    auto& mine = *static_cast<Implementation*>(self);
    auto& request = mine.request_;
    if (std::exchange(request.received, received) != received || std::exchange(request.sent, sent) != sent)
      mine.heard();
    request.stopped = interrupted();
    const bool silent = request.connected && Clock::now() - request.lastByte > mine.endpoint_.readTimeout;
    return request.stopped || silent ? 1 : 0;
  }

  void explain(CURLcode code, HttpReply& reply) const {
    if (request_.tooLong || code == CURLE_OUT_OF_MEMORY || code == kTooLarge) {  // the latter: a header
      reply.problem = fmt::format("its answer is longer than {} bytes", endpoint_.longestAnswer);
      reply.hopeless = true;
      return;
    }
    switch (code) {
      case CURLE_COULDNT_RESOLVE_HOST:
      case CURLE_COULDNT_CONNECT:
        reply.problem = "no connection";
        return;
      case CURLE_OPERATION_TIMEDOUT:
        reply.problem = request_.connected
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

  const HttpEndpoint endpoint_;
  CurlHandle curl_;
  std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers_;
  Request request_;
};

HttpConnection::HttpConnection(HttpEndpoint endpoint)
    : implementation_(std::make_unique<Implementation>(std::move(endpoint))) {}
HttpConnection::~HttpConnection() = default;

HttpReply HttpConnection::post(const std::string& body) {
  return implementation_->post(body);
}

}  // namespace estancia
