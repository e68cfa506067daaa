// Page server: the page and the API of a live view at an address.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/options.hpp"
#include "estancia/site/live_site.hpp"

namespace estancia {

struct ServerOptions {
  bool page = true;
  std::optional<int> port;  ///< 8765 when absent, else any that is free
  std::string listen;
};
/// Declares the options and their ranges.
OptionGroup declare(ServerOptions& options);

/// Serves until it is destroyed.
class PageServer {
 public:
  /// Does not depend on ServerOptions::page. The view must outlive it. Throws Error as makeHttpServer() does.
  PageServer(LiveView& view, const ServerOptions& options);

  /// Address to open; with the token if one is needed.
  const std::string& url() const { return url_; }
  int port() const { return server_->port(); }

 private:
  LiveSite site_;
  std::unique_ptr<HttpServer> server_;
  std::string url_;
};

}  // namespace estancia
