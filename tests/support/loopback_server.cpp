// SPDX-License-Identifier: Apache-2.0
#include "support/loopback_server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <sstream>

namespace estancia::test {
namespace {

std::string head(const std::string& status, std::size_t length, const std::vector<std::string>& headers) {
  std::string text =
      fmt::format("HTTP/1.1 {}\r\nContent-Length: {}\r\nConnection: close\r\n", status, length);
  for (const auto& line : headers) text += line + "\r\n";
  return text + "\r\n";
}

HttpRequest parse(const std::string& text) {
  HttpRequest request;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  std::istringstream(line) >> line >> request.path;
  while (std::getline(lines, line) && line != "\r") {
    const auto colon = line.find(": ");
    std::string name = line.substr(0, colon);
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    if (colon != std::string::npos) request.headers[name] = line.substr(colon + 2, line.size() - colon - 3);
  }
  return request;
}

}  // namespace

std::string httpAnswer(const std::string& status, const std::string& body,
                       const std::vector<std::string>& headers) {
  return head(status, body.size(), headers) + body;
}

std::string cutAnswer(const std::string& body, std::size_t count, const std::vector<std::string>& headers) {
  return head("200 OK", body.size(), headers) + body.substr(0, count);
}

std::string rangeAnswer(const HttpRequest& request, const std::string& body, const std::string& etag) {
  std::vector<std::string> headers;
  if (!etag.empty()) headers.push_back("ETag: " + etag);
  const auto range = request.headers.find("range"), condition = request.headers.find("if-range");
  if (range == request.headers.end() || (condition != request.headers.end() && condition->second != etag))
    return httpAnswer("200 OK", body, headers);
  const std::size_t from = std::stoul(range->second.substr(std::string("bytes=").size()));
  if (from >= body.size()) return httpAnswer("416 Range Not Satisfiable", "", headers);
  headers.push_back(fmt::format("Content-Range: bytes {}-{}/{}", from, body.size() - 1, body.size()));
  return httpAnswer("206 Partial Content", body.substr(from), headers);
}

LoopbackServer::LoopbackServer(Handler handler)
    : handler_(std::move(handler)), listener_(listenOnLoopback()) {
  accepting_ = std::thread([this] { accept(); });
}

LoopbackServer::~LoopbackServer() {
  ending_ = true;
  accepting_.join();
  for (std::thread& connection : connections_) connection.join();
  close(listener_.socket);
}

std::string LoopbackServer::url(const std::string& path) const {
  return fmt::format("http://127.0.0.1:{}{}", listener_.port, path);
}

std::vector<HttpRequest> LoopbackServer::requests() const {
  const std::lock_guard lock(mutex_);
  return requests_;
}

void LoopbackServer::accept() {
  while (!ending_) {
    pollfd ready{listener_.socket, POLLIN, 0};
    if (poll(&ready, 1, 20) != 1) continue;
    const int connection = accept4(listener_.socket, nullptr, nullptr, SOCK_CLOEXEC);
    if (connection >= 0) connections_.emplace_back([this, connection] { serve(connection); });
  }
}

void LoopbackServer::serve(int connection) {
  const HttpRequest request = parse(hearRequest(connection));
  {
    const std::lock_guard lock(mutex_);
    requests_.push_back(request);
  }
  const HttpAnswer answer = handler_(request);
  std::size_t sent = 0;
  while (sent < answer.bytes.size()) {
    const auto count = send(connection, answer.bytes.data() + sent, answer.bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) break;
    sent += static_cast<std::size_t>(count);
  }
  while (answer.hang && !ending_) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  shutdown(connection, SHUT_WR);
  close(connection);
}

}  // namespace estancia::test
