// An HTTP server on this machine that answers byte for byte what a test wants, broken answers included.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "support/loopback.hpp"

namespace estancia::test {

struct HttpRequest {
  std::string path;
  std::map<std::string, std::string> headers;  ///< names in lower case
};

struct HttpAnswer {
  std::string bytes;  ///< all that is sent, head and body; then the connection is closed …
  bool hang = false;  ///< … or only when the server ends
};

/// `status` is e.g. "200 OK"; `headers` are lines "Name: value". Content-Length is that of `body`.
std::string httpAnswer(const std::string& status, const std::string& body,
                       const std::vector<std::string>& headers = {});

/// The first `count` bytes of `body` where all of them were promised.
std::string cutAnswer(const std::string& body, std::size_t count,
                      const std::vector<std::string>& headers = {});

/// What a good server gives: all of `body`, or the rest that the request asks for unless If-Range names
/// another `etag`.
std::string rangeAnswer(const HttpRequest& request, const std::string& body, const std::string& etag = "");

class LoopbackServer {
 public:
  using Handler = std::function<HttpAnswer(const HttpRequest&)>;

  explicit LoopbackServer(Handler handler);
  ~LoopbackServer();
  LoopbackServer(const LoopbackServer&) = delete;
  LoopbackServer& operator=(const LoopbackServer&) = delete;

  std::string url(const std::string& path) const;
  /// Everything asked so far.
  std::vector<HttpRequest> requests() const;

 private:
  void accept();
  void serve(int connection);

  Handler handler_;
  Listener listener_;
  std::atomic<bool> ending_ = false;
  mutable std::mutex mutex_;
  std::vector<HttpRequest> requests_;
  std::vector<std::thread> connections_;
  std::thread accepting_;
};

}  // namespace estancia::test
