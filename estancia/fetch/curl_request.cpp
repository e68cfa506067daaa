// SPDX-License-Identifier: Apache-2.0
#include "estancia/fetch/curl_request.hpp"

#include "estancia/core/error.hpp"
#include "estancia/core/no_sigpipe.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {
namespace {

bool isCurlStarted() {
  static const CURLcode once = curl_global_init(CURL_GLOBAL_DEFAULT);
  return once == CURLE_OK;
}

[[noreturn]] void failToStart() {
  throw Error(ErrorCode::missingDependency, "libcurl cannot be started; is there memory left?");
}

/// Protocols are names from libcurl 7.85 on, and numbers before.
#if ESTANCIA_CURL_NAMES_PROTOCOLS
constexpr CURLoption protocols = CURLOPT_PROTOCOLS_STR, redirectProtocols = CURLOPT_REDIR_PROTOCOLS_STR;
constexpr const char *https = "https", *httpOrHttps = "http,https";
#else
constexpr CURLoption protocols = CURLOPT_PROTOCOLS, redirectProtocols = CURLOPT_REDIR_PROTOCOLS;
constexpr long https = CURLPROTO_HTTPS, httpOrHttps = CURLPROTO_HTTP | CURLPROTO_HTTPS;
#endif

}  // namespace

template <class Call>
bool CurlRequest::guarded(Call call) noexcept {
  try {
    return call();
  } catch (...) {
    failure_ = std::current_exception();
    return false;
  }
}

CurlConnections::CurlConnections()
    : share_(isCurlStarted() ? curl_share_init() : nullptr, &curl_share_cleanup) {
  if (!share_) failToStart();
  for (const curl_lock_data what : {CURL_LOCK_DATA_CONNECT, CURL_LOCK_DATA_DNS, CURL_LOCK_DATA_SSL_SESSION})
    curl_share_setopt(share_.get(), CURLSHOPT_SHARE, what);
}

CurlConnections::~CurlConnections() {
  const NoSigpipe quiet;  // closing a TLS connection writes to the socket
  share_.reset();
}

CurlRequest::CurlRequest()
    : curl_(isCurlStarted() ? curl_easy_init() : nullptr, &curl_easy_cleanup),
      headers_(nullptr, &curl_slist_free_all) {
  if (!curl_) failToStart();
  set(CURLOPT_USERAGENT, "estancia");
  set(protocols, httpOrHttps);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_NOPROGRESS, 0L);
  CURL* const curl = curl_.get();
  require(curl_easy_setopt(
      curl, CURLOPT_PREREQFUNCTION, +[](void* self, char*, char*, int, int) {
        auto& r = *static_cast<CurlRequest*>(self);
        return r.guarded([&] { return r.onConnected(); }) ? CURL_PREREQFUNC_OK : CURL_PREREQFUNC_ABORT;
      }));
  require(curl_easy_setopt(
      curl, CURLOPT_HEADERFUNCTION, +[](char* data, std::size_t one, std::size_t count, void* self) {
        auto& r = *static_cast<CurlRequest*>(self);
        const std::string_view line(data, one * count);
        return r.guarded([&] { return r.onHeader(line); }) ? line.size() : std::size_t{CURL_WRITEFUNC_ERROR};
      }));
  require(curl_easy_setopt(
      curl, CURLOPT_WRITEFUNCTION, +[](char* data, std::size_t one, std::size_t count, void* self) {
        auto& r = *static_cast<CurlRequest*>(self);
        const std::string_view bytes(data, one * count);
        return r.guarded([&] { return r.onBody(bytes); }) ? bytes.size() : std::size_t{CURL_WRITEFUNC_ERROR};
      }));
  require(curl_easy_setopt(
      curl, CURLOPT_XFERINFOFUNCTION,
      +[](void* self, curl_off_t, curl_off_t received, curl_off_t, curl_off_t sent) {
        auto& r = *static_cast<CurlRequest*>(self);
        r.stopped_ = interrupted();
        return r.guarded([&] { return r.onProgress(received, sent); }) && !r.stopped_ ? 0 : 1;
      }));
  for (const CURLoption data :
       {CURLOPT_PREREQDATA, CURLOPT_HEADERDATA, CURLOPT_WRITEDATA, CURLOPT_XFERINFODATA})
    set(data, this);
}

CurlRequest::~CurlRequest() {
  const NoSigpipe quiet;  // closing a TLS connection writes to the socket
  curl_.reset();
}

void CurlRequest::followRedirections(bool fromHttps) {
  set(CURLOPT_FOLLOWLOCATION, 1L);
  set(CURLOPT_MAXREDIRS, 8L);
  set(redirectProtocols, fromHttps ? https : httpOrHttps);
}

void CurlRequest::require(CURLcode code) {
  if (code != CURLE_OK)
    throw Error(ErrorCode::missingDependency,
                "libcurl lacks an option that is needed; install a complete one");
}

void CurlRequest::addHeader(const std::string& line) {
  curl_slist* const longer = curl_slist_append(headers_.get(), line.c_str());
  if (longer == nullptr) throw Error(ErrorCode::tooLarge, "no memory left for the headers of a request");
  static_cast<void>(headers_.release());  // a part of the longer one
  headers_.reset(longer);
  set(CURLOPT_HTTPHEADER, headers_.get());
}

CURLcode CurlRequest::perform() {
  stopped_ = false;
  failure_ = nullptr;
  const NoSigpipe quiet;
  const CURLcode code = curl_easy_perform(curl_.get());
  if (failure_) std::rethrow_exception(failure_);
  return code;
}

std::string CurlRequest::header(const char* name) const {
  curl_header* found = nullptr;
  return curl_easy_header(curl_.get(), name, 0, CURLH_HEADER, -1, &found) == CURLHE_OK ? found->value : "";
}

}  // namespace estancia
