// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/mcp.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/no_sigpipe.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/site/mcp_tools.hpp"
#include "estancia/version.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

/// The newest first.
constexpr std::array<std::string_view, 2> mcpVersions{"2025-06-18", "2024-11-05"};

// JSON-RPC 2.0, 5.1
constexpr int parseError = -32700, invalidRequest = -32600, methodNotFound = -32601, invalidParams = -32602,
              internalError = -32603;

/// An error of the protocol; those of tools are answers.
struct ProtocolError {
  int code;
  std::string message;
};

std::string errorText(const nlohmann::json& id, const ProtocolError& error) {
  return textOf(Json{
      {"jsonrpc", "2.0"}, {"id", Json(id)}, {"error", {{"code", error.code}, {"message", error.message}}}});
}

Json toolResult(std::string text, bool isError) {
  return {{"content", {{{"type", "text"}, {"text", std::move(text)}}}}, {"isError", isError}};
}

}  // namespace

std::string McpServer::answer(std::string_view line) {
  const nlohmann::json message = nlohmann::json::parse(line, nullptr, false);
  if (message.is_discarded()) return errorText(nullptr, {parseError, "this line is no JSON"});
  if (!message.is_object())
    return errorText(nullptr, {invalidRequest, message.is_array() ? "batches are not part of this version"
                                                                  : "a message is a JSON object"});
  const auto id = message.find("id"), method = message.find("method");
  const bool hasId = id != message.end();
  if (hasId && !id->is_string() && !id->is_number())
    return errorText(nullptr, {invalidRequest, "an id is a text or a number"});
  const nlohmann::json asked = hasId ? *id : nlohmann::json();
  if (method == message.end() && (message.contains("result") || message.contains("error")))
    return "";  // we ask for nothing
  if (message.value("jsonrpc", nlohmann::json()) != "2.0" || method == message.end() || !method->is_string())
    return errorText(asked, {invalidRequest, "a request has \"jsonrpc\": \"2.0\" and a \"method\""});
  if (!hasId) return "";  // notifications change nothing here
  const auto params = message.find("params");
  try {
    Json result = answerRequest(method->get<std::string>(),
                                params == message.end() ? nlohmann::json::object() : *params);
    return textOf(Json{{"jsonrpc", "2.0"}, {"id", Json(asked)}, {"result", std::move(result)}});
  } catch (const ProtocolError& error) {
    return errorText(asked, error);
  } catch (const std::exception& e) {
    return errorText(asked, {internalError, printable(e.what())});
  }
}

Json McpServer::answerRequest(const std::string& method, const nlohmann::json& params) {
  if (!params.is_object()) throw ProtocolError{invalidParams, "\"params\" must be an object"};
  if (method == "initialize") return initialize(params);
  if (method == "ping") return Json::object();
  if (method == "tools/list") return {{"tools", mcpTools()}};
  if (method == "tools/call") return call(params);
  throw ProtocolError{methodNotFound, fmt::format("there is no method \"{}\"", printable(method))};
}

Json McpServer::initialize(const nlohmann::json& params) {
  const auto wanted = params.find("protocolVersion");
  if (wanted == params.end() || !wanted->is_string())
    throw ProtocolError{invalidParams, "\"protocolVersion\" must be a text"};
  const auto known = std::ranges::find(mcpVersions, wanted->get<std::string>());
  version_ = known == mcpVersions.end() ? mcpVersions.front() : *known;
  return {{"protocolVersion", version_},
          {"capabilities", {{"tools", {{"listChanged", false}}}}},
          {"serverInfo", {{"name", "estancia"}, {"title", "Estancia"}, {"version", version()}}},
          {"instructions",
           "A robot's memory of the building it drove through: a map of places, areas (rooms) and objects. "
           "Lengths are meters, angles radians. Start with list_areas or find."}};
}

Json McpServer::call(const nlohmann::json& params) const {
  const auto name = params.find("name"), arguments = params.find("arguments");
  if (name == params.end() || !name->is_string())
    throw ProtocolError{invalidParams, "\"name\" must be the name of a tool"};
  const nlohmann::json given =
      arguments == params.end() || arguments->is_null() ? nlohmann::json::object() : *arguments;
  if (!given.is_object()) throw ProtocolError{invalidParams, "\"arguments\" must be an object"};
  try {
    auto answer = callTool(queries_, name->get<std::string>(), given);
    if (!answer)
      throw ProtocolError{invalidParams,
                          fmt::format("there is no tool \"{}\"", printable(name->get<std::string>()))};
    Json result = toolResult(std::move(answer->text), false);
    if (version_ != "2024-11-05") result["structuredContent"] = std::move(answer->content);
    return result;
  } catch (const Error& e) {
    // The agent reads it, and asks in another way.
    return toolResult(printable(e.what()), true);
  }
}

namespace {

/// False if the reader has closed the pipe.
bool writeLine(int out, std::string text) {
  const NoSigpipe guard;
  text += '\n';
  for (std::string_view left = text; !left.empty();) {
    const ssize_t written = ::write(out, left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    left.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// Lines of at most `longest` bytes; what is longer is passed over.
class BoundedLines {
 public:
  /// Calls `visit(line, isWhole)` for each line that ends in `bytes`; stops when it returns false.
  template <class Visit>
  bool add(std::string_view bytes, const Visit& visit) {
    constexpr std::size_t longest = 1 << 20;
    while (!bytes.empty()) {
      const std::size_t end = bytes.find('\n');
      const std::string_view part = bytes.substr(0, end);
      isTooLong_ = isTooLong_ || line_.size() + part.size() > longest;
      if (!isTooLong_) line_ += part;
      if (end == std::string_view::npos) return true;
      bytes.remove_prefix(end + 1);
      if (!line_.empty() && line_.back() == '\r') line_.pop_back();
      if ((isTooLong_ || !line_.empty()) && !visit(line_, !isTooLong_)) return false;
      line_.clear();
      isTooLong_ = false;
    }
    return true;
  }

 private:
  std::string line_;
  bool isTooLong_ = false;
};

}  // namespace

void serveMcp(McpServer& server, int in, int out, const std::function<bool()>& stopped) {
  constexpr int patience = 200;  // [ms]
  std::array<char, 16384> buffer{};
  BoundedLines lines;
  const auto answerLine = [&](const std::string& line, bool isWhole) {
    const std::string answer = isWhole
                                   ? server.answer(line)
                                   : errorText(nullptr, {invalidRequest, "this line is longer than 1 MiB"});
    return answer.empty() || writeLine(out, answer);
  };
  while (!stopped()) {
    pollfd ready{in, POLLIN, 0};
    const int count = ::poll(&ready, 1, patience);
    if (count == 0 || (count < 0 && errno == EINTR)) continue;
    const ssize_t got = count < 0 ? -1 : ::read(in, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0 || !lines.add({buffer.data(), static_cast<std::size_t>(got)}, answerLine)) return;
  }
}

}  // namespace estancia
