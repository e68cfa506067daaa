// SPDX-License-Identifier: Apache-2.0
#include "fuzz/answering_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace estancia::fuzz {
namespace {

bool isWhole(const std::string& request) {
  constexpr std::string_view end = "\r\n\r\n", length = "\nContent-Length: ";
  const std::size_t head = request.find(end), body = request.find(length);
  if (head == std::string::npos) return false;
  const std::size_t size = body < head ? std::stoul(request.substr(body + length.size())) : 0;
  return request.size() >= head + end.size() + size;
}

}  // namespace

AnsweringServer::AnsweringServer() : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener_, generic, size) != 0 || listen(listener_, 16) != 0 ||
      getsockname(listener_, generic, &size) != 0)
    throw std::system_error(errno, std::generic_category(), "no port on the loopback interface");
  url_ = fmt::format("http://127.0.0.1:{}", ntohs(address.sin_port));
  serving_ = std::thread([this] { serve(); });
}

AnsweringServer::~AnsweringServer() {
  shutdown(listener_, SHUT_RDWR);  // accept() fails
  serving_.join();
  close(listener_);
}

void AnsweringServer::answerWith(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  bytes_ = bytes;
}

void AnsweringServer::serve() {
  for (int connection; (connection = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) {
    answer(connection);
    close(connection);
  }
}

void AnsweringServer::answer(int connection) {
  std::string request;
  std::array<char, 4096> block{};
  while (!isWhole(request)) {  // closing before would reset the connection
    const auto count = recv(connection, block.data(), block.size(), 0);
    if (count <= 0) return;
    request.append(block.data(), static_cast<std::size_t>(count));
  }
  const std::lock_guard lock(mutex_);
  send(connection, bytes_.data(), bytes_.size(),
       MSG_NOSIGNAL);  // a few kilobytes fit into the socket's buffer
}

}  // namespace estancia::fuzz
