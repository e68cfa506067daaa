// An HTTP server on this machine whose every answer is the bytes of the input.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <thread>

namespace estancia::fuzz {

class AnsweringServer {
 public:
  /// Throws std::system_error where the loopback interface gives no port.
  AnsweringServer();
  ~AnsweringServer();
  AnsweringServer(const AnsweringServer&) = delete;
  AnsweringServer& operator=(const AnsweringServer&) = delete;

  /// "http://127.0.0.1:port"
  const std::string& url() const { return url_; }
  /// Head and body of the answers from now on; the connection is closed after each.
  void answerWith(std::string_view bytes);

 private:
  void serve();

  int listener_ = -1;
  std::string url_;
  std::mutex mutex_;
  std::string bytes_;
  std::thread serving_;
};

}  // namespace estancia::fuzz
