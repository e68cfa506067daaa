// SPDX-License-Identifier: Apache-2.0
#include "page_service.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/live/map_file_view.hpp"
#include "estancia/site/mcp.hpp"

namespace estancia::apps {

void PageArguments::addTo(DeclaredOptions& declared) {
  declared.add(declare(server), {"port", "listen", "page"});
  declared.command().add_flag("--mcp", mcp,
                              "Let agents ask, too: the Model Context Protocol on standard input and output");
}

PageService::PageService(LiveView& view, const PageArguments& arguments, std::function<void()> agentGone) {
  if (arguments.server.page) {
    page_.emplace(view, arguments.server);
    fmt::print(stderr, "the page is at {}\n", page_->url());
  }
  if (!arguments.mcp) return;
  agent_ = std::thread([this, &view, agentGone = std::move(agentGone)] {
    McpServer server(view);
    serveMcp(server, STDIN_FILENO, STDOUT_FILENO, [this] { return over_.load(); });
    if (!over_) agentGone();
  });
}

PageService::~PageService() {
  over_ = true;
  if (agent_.joinable()) agent_.join();
}

void serveMapFile(const std::string& map, const PageArguments& arguments) {
  if (!arguments.server.page && !arguments.mcp)
    throw Error(ErrorCode::invalidOption,
                "a map at rest without the page has nothing to do; leave out --no-page");
  MapFileView view(map);
  std::atomic<bool> isOver = false;
  const PageService service(view, arguments, [&isOver] { isOver = true; });
  while (!isOver && !interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

}  // namespace estancia::apps
