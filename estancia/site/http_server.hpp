// HTTP server: requests in, answers and event streams out, by a module of cpp-httplib opened on demand.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace estancia {

struct ServerRequest {
  std::string method;  ///< "GET", "POST"; HEAD comes as GET
  std::string path;    ///< decoded, without the query
  std::multimap<std::string, std::string> query = {};
  std::multimap<std::string, std::string> headers = {};  ///< names in lower case
  std::string body = {};

  /// nullptr where there is none, or more than one.
  const std::string* findHeader(const std::string& name) const;
};

struct ServerResponse {
  int status = 200;
  std::string type = {};
  std::string body = {};
  std::vector<std::pair<std::string, std::string>> headers = {};
  /// Instead of a body: what to send next, "" when there is nothing yet; nothing at the end. Called by one
  /// thread, again and again; must return in less than a second.
  std::function<std::optional<std::string>()> events = {};
};

/// Called by one thread a connection, several at a time. Must not throw.
class HttpHandler {
 public:
  virtual ~HttpHandler() = default;
  /// Before the body is read: an answer that refuses the request.
  virtual std::optional<ServerResponse> refusal(const ServerRequest& head) = 0;
  virtual ServerResponse answer(const ServerRequest& request) = 0;
};

/// Limits of a server; clients beyond them are refused.
struct HttpLimits {
  std::size_t connections = 64;            ///< at once, each with a thread of its own
  std::size_t head = 16384, body = 65536;  ///< [bytes]
  double patience = 10;  ///< for a request to come, an answer to be taken, and between requests [s]
};

/// Serves until it is destroyed.
class HttpServer {
 public:
  virtual ~HttpServer() = default;
  virtual int port() const = 0;
};

/// At an address of this machine; port 0: any that is free. The handler must outlive the server. Throws
/// Error: network where it cannot listen there; missingDependency where the module cannot be opened.
std::unique_ptr<HttpServer> makeHttpServer(const std::string& address, int port, HttpHandler& handler,
                                           const HttpLimits& limits = {});

}  // namespace estancia
