// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/page_server.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>

#include "estancia/core/error.hpp"

namespace estancia {

OptionGroup declare(ServerOptions& options) {
  OptionGroup group("server", "the page and its API");
  group.add("page", &options.page, "Serve the page and the API")
      .why("Off for a robot that nobody asks: nothing listens then.");
  group.add("port", &options.port, "Port to listen at; 0: any that is free")
      .range(0, 65535)
      .automatic("8765, else any that is free");
  group.add("listen", &options.listen, "Address to listen at; 0.0.0.0 for all of this machine")
      .automatic("this machine alone can connect")
      .why(
          "To open the page from another machine. A token is printed then, which every request must have. "
          "The connection is not encrypted: use it in a network that you trust.");
  return group;
}

namespace {

std::unique_ptr<HttpServer> listenAt(const std::string& address, std::optional<int> port,
                                     HttpHandler& handler) {
  constexpr int usual = 8765;
  if (port) return makeHttpServer(address, *port, handler);
  try {
    return makeHttpServer(address, usual, handler);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::network) throw;
    return makeHttpServer(address, 0, handler);
  }
}

}  // namespace

PageServer::PageServer(LiveView& view, const ServerOptions& options) : site_(view) {
  validate(options);
  std::string host = options.listen.empty() ? "127.0.0.1" : options.listen;
  server_ = listenAt(host, options.port, site_);
  const SiteAccess access{options.listen, server_->port(), options.listen.empty() ? "" : makeToken()};
  site_.open(access);
  if (host == "0.0.0.0" || host == "::") {
    std::array<char, 256> name{};
    host = gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0' ? name.data() : "127.0.0.1";
  }
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  url_ =
      fmt::format("http://{}:{}/{}", host, access.port, access.token.empty() ? "" : "?token=" + access.token);
}

}  // namespace estancia
