// Site access: who may ask the server, and change the map: names of the server, origins, tokens.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/site/http_server.hpp"

namespace estancia {

struct SiteAccess {
  std::string listen;  ///< the address or name that the server listens at; "" for this machine alone
  int port = 0;
  std::string token;  ///< token that every request must contain; "" for none

  /// How the cookie with the token is called. Cookies do not know of ports.
  std::string cookieName() const { return "estancia-" + std::to_string(port); }
};

struct AccessRefusal {
  int status = 403;
  std::string why;  ///< the problem, and advice
};

/// Nothing for a request that may go on. Refused are:
/// - names of the server that are not its own, by which a page of another site would reach it (DNS
///   rebinding). A server that listens at all addresses has its own host name, and addresses in digits, which
/// cannot be rebound;
/// - pages of other origins (Origin, Sec-Fetch-Site), but for following a link;
/// - requests without the token: in the query (?token=…), as a cookie, or as "Authorization: Bearer …";
/// - POST of other than JSON, which no other page can send unasked (CORS).
std::optional<AccessRefusal> accessRefusal(const ServerRequest& request, const SiteAccess& access);

/// Whether the token came in the query: then a cookie keeps it.
bool isTokenInQuery(const ServerRequest& request, const SiteAccess& access);

/// 128 random bits of the operating system, as hex digits.
std::string makeToken();

}  // namespace estancia
