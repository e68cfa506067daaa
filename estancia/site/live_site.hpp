// Live site: the page and the API of a live view, without a socket: what is answered to which request.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "estancia/site/queries.hpp"
#include "estancia/site/site_access.hpp"

namespace estancia {

/// Serves the paths of openapi.json, and the page at "/". Failures are answered as {"error": {"code",
/// "message"}}; the code is that of an ErrorCode, or "forbidden", "unauthorized", "method-not-allowed",
/// "not-found", "wrong-type", "too-many".
class LiveSite final : public HttpHandler {
 public:
  /// The view must outlive it.
  explicit LiveSite(LiveView& view) : view_(view), queries_(view) {}

  /// Until then every request is refused.
  void open(const SiteAccess& access);

  std::optional<ServerResponse> refusal(const ServerRequest& head) override;
  ServerResponse answer(const ServerRequest& request) override;

  /// "GET /api/places/{node}" and the like: all that the API serves, for openapi.json.
  static std::vector<std::string> operations();

  /// Each keeps a connection: streams of events at once, of HttpLimits::connections.
  static constexpr int maxStreams = 48;

 private:
  struct Operation;
  struct Question;
  static const std::vector<Operation>& all();
  static std::vector<Operation> makeOperations();

  ServerResponse events(const ServerRequest& request);
  /// The status as an event, made once for all who listen.
  std::shared_ptr<const std::string> eventOf(const LiveStatus& status);

  LiveView& view_;
  LiveQueries queries_;
  std::mutex mutex_;  // guards the members below
  std::optional<SiteAccess> access_;
  std::uint64_t eventRevision_ = 0;
  std::shared_ptr<const std::string> event_;
  std::shared_ptr<std::atomic<int>> streams_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace estancia
