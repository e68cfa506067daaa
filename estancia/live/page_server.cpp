// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/page_server.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>

namespace estancia {

OptionGroup declare(ServerOptions& options) {
  OptionGroup group("server", "the page and its API");
  group.add("page", &options.page, "Serve the page and the API")
      .why("Off for a robot that nobody asks: nothing listens then.");
  group.add("port", &options.port, "Port to listen at; 0: any that is free").range(0, 65535);
  group.add("listen", &options.listen, "Address to listen at; 0.0.0.0 for all of this machine")
      .automatic("this machine alone can connect")
      .why(
          "To open the page from another machine. A token is printed then, which every request must have. "
          "The "
          "connection is not encrypted: use it in a network that you trust.");
  return group;
}

PageServer::PageServer(LiveView& view, const ServerOptions& options) : site_(view) {
  validate(options);
  SiteAccess access{options.listen, 0, options.listen.empty() ? "" : makeToken()};
  server_ = makeHttpServer(options.listen.empty() ? "127.0.0.1" : options.listen, options.port, site_);
  access.port = server_->port();
  site_.open(access);
  std::string host = options.listen.empty() ? "127.0.0.1" : options.listen;
  if (host == "0.0.0.0" || host == "::") {
    std::array<char, 256> name{};
    host = gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0' ? name.data() : "127.0.0.1";
  }
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  url_ =
      fmt::format("http://{}:{}/{}", host, access.port, access.token.empty() ? "" : "?token=" + access.token);
}

}  // namespace estancia
