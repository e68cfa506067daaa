// HTTP request: one transfer of libcurl, with what all of ours have in common.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <curl/curl.h>

#include <exception>
#include <memory>
#include <string>
#include <string_view>

namespace estancia {

/// Connections that stay open for the next request. Not thread-safe.
class CurlConnections {
 public:
  /// Throws Error when libcurl has no memory for them.
  CurlConnections();
  ~CurlConnections();
  CurlConnections(const CurlConnections&) = delete;
  CurlConnections& operator=(const CurlConnections&) = delete;

  CURLSH* share() const { return share_.get(); }

 private:
  std::unique_ptr<CURLSH, decltype(&curl_share_cleanup)> share_;
};

/// Base of the classes that speak HTTP: http and https only, no signals, exceptions kept out of C, Ctrl-C
/// within about a second. They set further options and define what is done with the answer. Each object
/// performs one request: until curl's pull request 11103 (May 2023) a handle's second answer, if its first
/// header is folded, goes into freed memory.
class CurlRequest {
 public:
  CurlRequest(const CurlRequest&) = delete;
  CurlRequest& operator=(const CurlRequest&) = delete;

 protected:
  /// Throws Error when libcurl cannot be started.
  CurlRequest();
  virtual ~CurlRequest();

  /// Throws Error when libcurl does not know the option.
  template <class Value>
  void set(CURLoption option, Value value) {
    require(curl_easy_setopt(curl_.get(), option, value));
  }
  /// A line "Name: value" to send.
  void addHeader(const std::string& line);
  /// Follows redirections, from https to https only.
  void followRedirections(bool fromHttps);
  /// Uses them, and leaves its connection there. They must outlive this.
  void useConnections(const CurlConnections& connections) { set(CURLOPT_SHARE, connections.share()); }
  void setUrl(const std::string& url) { set(CURLOPT_URL, url.c_str()); }

  /// Sends the request and receives the answer. Throws what the functions below throw.
  CURLcode perform();
  /// Whether perform() ended because the user asked to stop.
  bool stopped() const { return stopped_; }

  long status() const { return info<long>(CURLINFO_RESPONSE_CODE); }
  /// A header of the answer; "" when it is absent.
  std::string header(const char* name) const;
  template <class Value>
  Value info(CURLINFO what) const {
    Value value{};
    curl_easy_getinfo(curl_.get(), what, &value);
    return value;
  }

  // Called while perform() runs. False ends the request.
  virtual bool onConnected() { return true; }
  virtual bool onHeader(std::string_view) { return true; }
  virtual bool onBody(std::string_view bytes) = 0;
  /// At least once a second, with the bytes so far.
  virtual bool onProgress(curl_off_t /*received*/, curl_off_t /*sent*/) { return true; }

 private:
  static void require(CURLcode code);
  template <class Call>
  bool guarded(Call call) noexcept;

  std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl_;
  std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers_;
  bool stopped_ = false;
  std::exception_ptr failure_;  // must not pass through C
};

}  // namespace estancia
