// An HTTP client that sends byte for byte what a test wants.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <stdexcept>
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
  explicit WebClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("nobody listens at port " + std::to_string(port));
  }
  ~WebClient() { ::close(socket_); }
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  /// False when the server has closed.
  bool send(const std::string& bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t sent = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
      if (sent <= 0) return false;
      done += static_cast<std::size_t>(sent);
    }
    return true;
  }
  /// Announces that nothing more will be sent.
  void finish() { ::shutdown(socket_, SHUT_WR); }
  /// What comes until `end` has come, the server closes, or nothing comes for ten seconds.
  std::string readUntil(const std::string& end) {
    std::size_t at = 0;
    while ((at = buffer_.find(end)) == std::string::npos && receive()) {
    }
    at = at == std::string::npos ? buffer_.size() : at + end.size();
    std::string taken = buffer_.substr(0, at);
    buffer_.erase(0, at);
    return taken;
  }
  /// One answer with a Content-Length; status 0 where none comes.
  WebAnswer read() {
    WebAnswer answer;
    const std::string head = readUntil("\r\n\r\n");
    if (head.size() < 12 || !head.starts_with("HTTP/1.1 ")) return answer;
    answer.status = std::stoi(head.substr(9, 3));
    for (std::size_t at = head.find("\r\n") + 2, end = 0;
         (end = head.find("\r\n", at)) > at && end != std::string::npos; at = end + 2) {
      const std::string line = head.substr(at, end - at);
      const std::size_t colon = line.find(": ");
      std::string name = line.substr(0, colon);
      std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
      answer.headers[name] = line.substr(colon + 2);
    }
    const auto length = answer.headers.find("content-length");
    const std::size_t size = length == answer.headers.end() ? 0 : std::stoul(length->second);
    while (buffer_.size() < size && receive()) {
    }
    answer.body = buffer_.substr(0, size);
    buffer_.erase(0, size);
    return answer;
  }
  /// Takes little at a time from now on.
  void receiveSlowly() {
    const int small = 2048;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  }

 private:
  bool receive() {
    constexpr int patience = 10'000;  // [ms]
    pollfd state{socket_, POLLIN, 0};
    if (::poll(&state, 1, patience) <= 0) return false;
    std::array<char, 65536> part{};
    const ssize_t got = ::recv(socket_, part.data(), part.size(), 0);
    if (got <= 0) return false;
    buffer_.append(part.data(), static_cast<std::size_t>(got));
    return true;
  }

  int socket_ = -1;
  std::string buffer_;
};

/// A GET or, with a body of JSON, a POST, by a connection of its own. `more`: lines of headers.
inline WebAnswer fetchWeb(int port, const std::string& path, const std::string& more = "",
                          const std::string& json = "") {
  WebClient client(port);
  const std::string host = "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  if (json.empty())
    client.send("GET " + path + " HTTP/1.1\r\n" + host + more + "\r\n");
  else
    client.send("POST " + path + " HTTP/1.1\r\n" + host +
                "Content-Type: application/json\r\nContent-Length: " + std::to_string(json.size()) + "\r\n" +
                more + "\r\n" + json);
  return client.read();
}

}  // namespace estancia::test
