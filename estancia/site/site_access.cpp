// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/site_access.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "estancia/core/ascii.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {
namespace {

/// Compares in constant time for a given length, so that the time does not reveal how much was right.
bool isSameSecret(std::string_view given, std::string_view secret) {
  if (given.size() != secret.size()) return false;
  unsigned different = 0;
  for (std::size_t i = 0; i < secret.size(); ++i)
    different |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(secret[i]);
  return different == 0;
}

bool isAddress(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET, host.c_str(), bytes.data()) == 1) return true;
  return host.size() > 2 && host.front() == '[' && host.back() == ']' &&
         inet_pton(AF_INET6, host.substr(1, host.size() - 2).c_str(), bytes.data()) == 1;
}

std::string hostName() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? lowerCase(name.data()) : "";
}

/// Whether the value of a Host header names this server.
bool isOwnHost(std::string host, const SiteAccess& access) {
  host = lowerCase(std::move(host));
  const std::string port = ":" + std::to_string(access.port);
  if (host.ends_with(port))
    host.resize(host.size() - port.size());
  else if (access.port != 80 || (host.find(':') != std::string::npos && !host.ends_with(']')))
    return false;
  for (const char* own : {"localhost", "127.0.0.1", "[::1]"})
    if (host == own) return true;
  if (access.listen.empty()) return false;
  const std::string listen = lowerCase(access.listen);
  if (host == listen || host == "[" + listen + "]") return true;
  if (listen != "0.0.0.0" && listen != "::") return false;
  const std::string own = hostName();
  return isAddress(host) || (!own.empty() && (host == own || host == own + ".local"));
}

bool isOfOtherSite(const ServerRequest& request) {
  if (request.headers.contains("origin")) {
    const std::string* origin = request.findHeader("origin");
    const std::string* host = request.findHeader("host");
    if (origin == nullptr || host == nullptr || lowerCase(*origin) != "http://" + lowerCase(*host))
      return true;
  }
  if (!request.headers.contains("sec-fetch-site")) return false;
  const std::string* site = request.findHeader("sec-fetch-site");
  const std::string* mode = request.findHeader("sec-fetch-mode");
  if (site != nullptr && (*site == "same-origin" || *site == "none")) return false;
  return request.method != "GET" || mode == nullptr || *mode != "navigate";
}

/// The value of a cookie in "a=1; b=2"; "" where there is none.
std::string cookieOf(const ServerRequest& request, const std::string& name) {
  const auto [first, last] = request.headers.equal_range("cookie");
  for (auto header = first; header != last; ++header) {
    std::string_view left = header->second;
    while (!left.empty()) {
      const std::size_t end = std::min(left.find(';'), left.size());
      std::string_view cookie = left.substr(0, end);
      left.remove_prefix(std::min(end + 1, left.size()));
      cookie.remove_prefix(std::min(cookie.find_first_not_of(' '), cookie.size()));
      if (cookie.starts_with(name + "=")) return std::string(cookie.substr(name.size() + 1));
    }
  }
  return "";
}

bool hasToken(const ServerRequest& request, const SiteAccess& access) {
  if (access.token.empty() || isTokenInQuery(request, access)) return true;
  if (isSameSecret(cookieOf(request, access.cookieName()), access.token)) return true;
  const std::string* authorization = request.findHeader("authorization");
  constexpr std::string_view bearer = "Bearer ";
  return authorization != nullptr && authorization->starts_with(bearer) &&
         isSameSecret(std::string_view(*authorization).substr(bearer.size()), access.token);
}

bool isJson(const ServerRequest& request) {
  const std::string* type = request.findHeader("content-type");
  if (type == nullptr || request.headers.contains("content-encoding")) return false;
  std::string essence = lowerCase(type->substr(0, type->find(';')));
  essence.resize(essence.find_last_not_of(" \t") + 1);
  return essence == "application/json";
}

}  // namespace

bool isTokenInQuery(const ServerRequest& request, const SiteAccess& access) {
  const auto found = request.query.find("token");
  return !access.token.empty() && found != request.query.end() && isSameSecret(found->second, access.token);
}

std::optional<AccessRefusal> accessRefusal(const ServerRequest& request, const SiteAccess& access) {
  const std::string* host = request.findHeader("host");
  if (host == nullptr || !isOwnHost(*host, access))
    return AccessRefusal{403, fmt::format("this server is not called \"{}\"; use the address that it printed",
                                          host == nullptr ? "" : printable(*host))};
  if (isOfOtherSite(request)) return AccessRefusal{403, "pages of other sites may not ask this server"};
  if (!hasToken(request, access))
    return AccessRefusal{401, "the token is missing or wrong; open the address that the server printed"};
  if (request.method == "POST" && !isJson(request))
    return AccessRefusal{415, "a change is sent as application/json, not compressed"};
  return std::nullopt;
}

std::string makeToken() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    fail(ErrorCode::invalidState, "the operating system gives no random numbers");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

}  // namespace estancia
