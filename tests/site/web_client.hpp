// An HTTP client that sends byte for byte what a test wants.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

namespace estancia::test {

struct WebAnswer {
  int status = 0;
  /// Names in lower case.
  std::map<std::string, std::string> headers;
  std::string body;
};

/// One connection to a server of this machine.
class WebClient {
 public:
  explicit WebClient(int port);
  ~WebClient();
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  /// False when the server has closed.
  bool send(const std::string& bytes);
  /// Announces that nothing more will be sent.
  void finish();
  /// What comes until `end` has come, the server closes, or nothing comes for ten seconds.
  std::string readUntil(const std::string& end);
  /// One answer with a Content-Length; status 0 where none comes.
  WebAnswer read();
  /// Takes little at a time from now on.
  void receiveSlowly();

 private:
  bool receive();

  int socket_ = -1;
  std::string buffer_;
};

/// A GET or, with a body of JSON, a POST, by a connection of its own. `more`: lines of headers.
WebAnswer fetchWeb(int port, const std::string& path, const std::string& more = "",
                   const std::string& json = "");

}  // namespace estancia::test
