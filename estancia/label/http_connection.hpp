// One connection to a web service, with a clock that nothing on the other side can stop.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace estancia {

/// Where and how to ask.
struct HttpEndpoint {
  std::string server;  ///< "https://host:port"
  std::string path;    ///< "/v2/label?lang=en", sent as it is
  std::string contentType;
  std::vector<std::pair<std::string, std::string>> headers;
  std::filesystem::path certificates;  ///< PEM of whom to trust; "" = whom the system trusts
  std::chrono::milliseconds connectTimeout{10'000};
  std::chrono::milliseconds readTimeout{30'000};  ///< of silence, to about a second
  std::chrono::milliseconds timeout{60'000};      ///< of the whole request, however its bytes trickle
  std::size_t maxAnswer = std::size_t{4} << 20U;  ///< [bytes]
};

/// What came back.
struct HttpReply {
  int status = 0;  ///< 0: no whole answer, see `problem`
  std::string body;
  std::string retryAfter, location;  ///< headers, "" when absent
  std::string problem;               ///< why there is no answer, one clause
  bool hopeless = false;             ///< the problem will be the same next time
};

/// Requests to one endpoint, one after the other, over one connection that is kept open between them. Uses no
/// proxy, follows no redirect, and checks certificate and host name of https. Not thread-safe.
class HttpConnection {
 public:
  explicit HttpConnection(HttpEndpoint endpoint);
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  /// Never throws for what the service does. Throws Interrupted within about a second of the user's wish to
  /// stop.
  HttpReply post(const std::string& body);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace estancia
