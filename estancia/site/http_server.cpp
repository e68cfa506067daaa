// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/http_server.hpp"

#include <fmt/format.h>

#include "estancia/core/fail.hpp"
#include "estancia/core/module_function.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {

const std::string* ServerRequest::findHeader(const std::string& name) const {
  const auto [first, last] = headers.equal_range(name);
  return first == last || std::next(first) != last ? nullptr : &first->second;
}

std::unique_ptr<HttpServer> makeHttpServer(const std::string& address, int port, HttpHandler& handler,
                                           const HttpLimits& limits) {
  using Make = HttpServer* (*)(const std::string&, int, HttpHandler&, const HttpLimits&);
  // After an exception the next call tries again.
  static const auto make = reinterpret_cast<Make>(getModuleFunction(
      ESTANCIA_HTTP_MODULE, ESTANCIA_HTTP_FROM_BIN, "estanciaMakeHttpServer", "no page can be served"));
  std::unique_ptr<HttpServer> server(make(address, port, handler, limits));
  if (server == nullptr)
    fail(ErrorCode::network, "cannot listen at {}, {}: {}", printable(address),
         port == 0 ? "any port" : fmt::format("port {}", port),
         port == 0 ? "this machine has no such address; give one that it has, or 0.0.0.0 for all"
                   : "another program does, or this machine has no such address; give another --port");
  return server;
}

}  // namespace estancia
