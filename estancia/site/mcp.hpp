// MCP server: the Model Context Protocol (JSON-RPC 2.0, a message a line), so that agents can ask a map.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "estancia/site/queries.hpp"

namespace estancia {

/// Tools of a LiveView: find, where_am_i, route_to, describe_place, list_areas. Speaks the versions
/// 2025-06-18 and 2024-11-05 of the protocol; neither has batches. Not thread-safe.
class McpServer {
 public:
  /// The view must outlive it.
  explicit McpServer(const LiveView& view) : queries_(view) {}

  /// The answer to one message, a line without its end; "" where none is due. What is no message is answered
  /// by an error. Throws nothing.
  std::string answer(std::string_view line);

 private:
  using Json = nlohmann::ordered_json;
  Json answerRequest(const std::string& method, const nlohmann::json& params);
  Json initialize(const nlohmann::json& params);
  Json call(const nlohmann::json& params) const;

  LiveQueries queries_;
  std::string version_ = "2025-06-18";
};

/// Answers what comes from the file descriptor `in` to `out` until `in` ends, the reader of `out` closes it,
/// or `stopped()`, which is asked a few times a second. Lines of more than 1 MiB are answered by an error.
void serveMcp(McpServer& server, int in, int out, const std::function<bool()>& stopped);

}  // namespace estancia
