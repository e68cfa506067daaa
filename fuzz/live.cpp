// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/edits.hpp"
#include "estancia/site/live_site.hpp"
#include "estancia/site/mcp.hpp"
#include "fuzz/fuzz_target.hpp"
#include "site/fake_view.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(live, edit) {
  parseEdit(std::string(bytes));
}

FUZZ_TARGET(live, mcp) {
  const test::FakeView view;
  McpServer server(view);
  for (const std::string_view line : parts(bytes, 3)) server.answer(line);
}

/// A request: method and path, a query, a header, each NAME=VALUE, and a body.
FUZZ_TARGET(live, request) {
  const auto texts = parts(bytes, 4);
  const auto pairOf = [](std::string_view text) {
    const std::size_t at = std::min(text.find('='), text.size());
    return std::pair(std::string(text.substr(0, at)),
                     std::string(text.substr(std::min(at + 1, text.size()))));
  };
  test::FakeView view;
  LiveSite site(view);
  site.open({.listen = "", .port = 8080, .token = "token"});
  const std::size_t blank = std::min(texts[0].find(' '), texts[0].size());
  ServerRequest request{.method = std::string(texts[0].substr(0, blank)),
                        .path = std::string(texts[0].substr(std::min(blank + 1, texts[0].size())))};
  request.query.insert(pairOf(texts[1]));
  request.headers.insert(pairOf(texts[2]));
  request.headers.emplace("host", "localhost:8080");
  site.refusal(request);
  request.headers.emplace("authorization", "Bearer token");
  request.headers.emplace("content-type", "application/json");
  request.body = texts[3];
  if (!site.refusal(request)) site.answer(request);
}

}  // namespace estancia::fuzz
