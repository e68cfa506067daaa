// SPDX-License-Identifier: Apache-2.0
#include "fuzz/answering_server.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "support/loopback.hpp"

namespace estancia::fuzz {

AnsweringServer::AnsweringServer() {
  test::withoutProxy();
  const test::Listener listener = test::listenOnLoopback();
  listener_ = listener.socket;
  url_ = fmt::format("http://127.0.0.1:{}", listener.port);
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
    test::hearRequest(connection);  // closing before would reset the connection
    const std::lock_guard lock(mutex_);
    // A few kilobytes fit into the socket's buffer at once.
    send(connection, bytes_.data(), bytes_.size(), MSG_NOSIGNAL);
    close(connection);
  }
}

}  // namespace estancia::fuzz
