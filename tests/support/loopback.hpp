// The loopback interface: ports to listen at, whole HTTP requests, and no proxy in between.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>

namespace estancia::test {

/// Lets this process and those it starts connect directly, whatever proxy the machine is set to.
inline void withoutProxy() {
  setenv("no_proxy", "*", 1);
}

struct Listener {
  int socket = -1, port = 0;
};

/// At any free port. Throws std::system_error where there is none.
inline Listener listenOnLoopback() {
  Listener listener{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listener.socket, generic, size) != 0 || ::listen(listener.socket, 16) != 0 ||
      ::getsockname(listener.socket, generic, &size) != 0)
    throw std::system_error(errno, std::generic_category(), "no port on the loopback interface");
  listener.port = ntohs(address.sin_port);
  return listener;
}

/// Head and body; what there was of it where the connection ended before.
inline std::string hearRequest(int connection) {
  constexpr std::string_view end = "\r\n\r\n", length = "\nContent-Length: ";
  std::string request;
  std::array<char, 65536> block{};
  for (std::size_t size = std::string::npos; request.size() < size;) {
    const auto count = ::recv(connection, block.data(), block.size(), 0);
    if (count <= 0) break;
    request.append(block.data(), static_cast<std::size_t>(count));
    const std::size_t head = request.find(end), body = request.find(length);
    if (head != std::string::npos)
      size = head + end.size() + (body < head ? std::stoul(request.substr(body + length.size())) : 0);
  }
  return request;
}

}  // namespace estancia::test
