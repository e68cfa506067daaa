// HTTP connection: POST requests to one web service, with timeouts that no server can stretch.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estancia/fetch/curl_request.hpp"

namespace estancia {

/// Where and how to ask.
struct HttpEndpoint {
  /// "https://host:port".
  std::string server;
  /// "/v2/label?lang=en", sent as it is.
  std::string path;
  std::string contentType;
  std::vector<std::pair<std::string, std::string>> headers;
  /// PEM file of trusted certificates; "" = those of the system.
  std::filesystem::path certificates;
  std::chrono::milliseconds connectTimeout{10'000};
  /// Limit of silence, to about a second.
  std::chrono::milliseconds readTimeout{30'000};
  /// Limit of the whole request, however slowly its bytes arrive.
  std::chrono::milliseconds timeout{60'000};
  /// [bytes].
  std::size_t maxAnswer = std::size_t{4} << 20U;
};

/// Answer of the service.
struct HttpReply {
  /// 0: no whole answer, see `problem`.
  int status = 0;
  std::string body;
  /// Headers, "" when absent.
  std::string retryAfter, location;
  /// Why there is no answer, one clause.
  std::string problem;
  /// The problem will be the same next time.
  bool hopeless = false;
};

/// Requests to one endpoint, one after the other, over one connection that is kept open between them. Uses no
/// proxy, follows no redirect, and checks certificate and host name of https. Not thread-safe.
class HttpConnection {
 public:
  /// Throws Error when the endpoint is no URL.
  explicit HttpConnection(HttpEndpoint endpoint);

  /// Never throws for what the service does. Throws Interrupted within about a second of the user's wish to
  /// stop.
  HttpReply post(const std::string& body);

 private:
  const HttpEndpoint endpoint_;
  const CurlConnections connections_;
};

}  // namespace estancia
