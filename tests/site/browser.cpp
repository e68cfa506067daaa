// SPDX-License-Identifier: Apache-2.0
#include "site/browser.hpp"

#include <cstdlib>
#include <vector>

namespace estancia::test {

ServerOptions optionsAt(int port) {
  ServerOptions options;
  options.port = port;
  return options;
}

std::future<CommandResult> browse(const PageServer& server, int width, const std::string& kind) {
  const auto modules = findFetched("test-tools/node_modules");
  if (!modules) return {};
  std::vector<std::string> arguments{std::string(ESTANCIA_SOURCE_DIR) + "/tests/site/page.mjs",
                                     modules->string(), server.url(), std::to_string(width), kind};
  if (const char* folder = std::getenv("ESTANCIA_SCREENSHOTS")) arguments.emplace_back(folder);
  return std::async(std::launch::async, [arguments] { return runProgram("node", arguments); });
}

}  // namespace estancia::test
