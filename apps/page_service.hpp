// Page and agents of a command: its options, and what serves them while it runs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "declared_options.hpp"
#include "estancia/live/live_view.hpp"
#include "estancia/site/page_server.hpp"

namespace estancia::apps {

struct PageArguments {
  ServerOptions server;
  bool mcp = false;
  /// Adds --port, --listen, --no-page and --mcp.
  void addTo(DeclaredOptions& declared);
};

/// Serves the page and, where --mcp is given, agents on standard input and output, until it is destroyed.
/// Prints the page's address on stderr.
class PageService {
 public:
  /// The view must outlive it. `agentGone` is called once, by another thread, when the agent has closed
  /// standard input.
  PageService(LiveView& view, const PageArguments& arguments, std::function<void()> agentGone);
  ~PageService();
  PageService(const PageService&) = delete;
  PageService& operator=(const PageService&) = delete;

 private:
  std::optional<PageServer> page_;
  std::atomic<bool> over_ = false;
  std::thread agent_;
};

/// Serves a map at rest until the user interrupts, or the agent goes.
void serveMapFile(const std::string& map, const PageArguments& arguments);

}  // namespace estancia::apps
