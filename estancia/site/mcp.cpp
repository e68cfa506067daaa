// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/mcp.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/no_sigpipe.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/version.hpp"

namespace estancia {
namespace {

/// An answer for machines, and the same in short for people and language models.
struct ToolAnswer {
  nlohmann::ordered_json content;
  std::string text;
};

using Json = nlohmann::ordered_json;
using Arguments = nlohmann::json;

/// Throws where an argument is missing, unknown, or of another type than in its schema.
class ToolArguments {
 public:
  ToolArguments(const Arguments& given, const Json& schema) : given_(given) {
    const Json& known = schema["properties"];
    for (const auto& [key, value] : given.items())
      if (!known.contains(key))
        fail(ErrorCode::invalidInput, "there is no argument \"{}\"{}", printable(key),
             known.empty() ? "; this tool takes none" : "");
    for (const Json& key : schema["required"])
      if (!given.contains(key.get<std::string>()))
        fail(ErrorCode::invalidInput, "the argument \"{}\" is missing", key.get<std::string>());
  }

  std::string text(const char* key) const {
    const Arguments& value = given_.at(key);
    if (!value.is_string() || value.get_ref<const std::string&>().empty())
      fail(ErrorCode::invalidInput, "the argument \"{}\" must be a text that is not empty", key);
    return value.get<std::string>();
  }
  std::optional<int> number(const char* key, int least, int most) const {
    const auto found = given_.find(key);
    if (found == given_.end()) return std::nullopt;
    const double value = found->is_number() ? found->get<double>() : std::nan("");
    if (!(value >= least && value <= most) || value != std::floor(value))
      fail(ErrorCode::invalidInput, "the argument \"{}\" must be a whole number from {} to {}", key, least,
           most);
    return static_cast<int>(value);
  }
  std::vector<std::string> texts(const char* key) const {
    const auto found = given_.find(key);
    if (found == given_.end()) return {};
    const auto isText = [](const Arguments& one) { return one.is_string(); };
    if (!found->is_array() || !std::ranges::all_of(*found, isText))
      fail(ErrorCode::invalidInput, "the argument \"{}\" must be a list of texts", key);
    return found->get<std::vector<std::string>>();
  }

 private:
  const Arguments& given_;
};

constexpr int anyNumber = std::numeric_limits<int>::max();

/// "kitchen" of {"name": "kitchen"}; "" of null.
std::string nameIn(const Json& reference) {
  return reference.is_null() || reference["name"].is_null() ? "" : reference["name"].get<std::string>();
}

std::string inArea(const Json& thing) {
  if (!thing.contains("area")) return "";
  const std::string name = nameIn(thing["area"]);
  return name.empty() ? "" : ", in " + name;
}

double percentOf(const Json& probability) {
  return 100 * probability.get<double>();
}

std::string objectText(const Json& object) {
  const Json& at = object["position"];
  const std::string on = nameIn(object["on"]);
  return fmt::format("object {}: {} ({:.0f} %) at ({:.2f}, {:.2f}, {:.2f}) m{}{}", object["id"].get<int>(),
                     object["name"].get<std::string>(), percentOf(object["probability"]), at[0].get<double>(),
                     at[1].get<double>(), at[2].get<double>(), on.empty() ? "" : ", on the " + on,
                     inArea(object));
}

std::string areaInShort(const Json& area) {
  return fmt::format("area {}: {}, {:.1f} m² around ({:.2f}, {:.2f}) m", area["id"].get<int>(),
                     area["name"].get<std::string>(), area["size"].get<double>(),
                     area["center"][0].get<double>(), area["center"][1].get<double>());
}

std::string findText(const Json& answers) {
  std::vector<std::string> lines;
  for (const Json& area : answers["areas"]) lines.push_back(areaInShort(area));
  for (const Json& object : answers["objects"]) lines.push_back(objectText(object));
  for (const Json& place : answers["places"])
    lines.push_back(fmt::format("place {} holds it with {:.1f} %{}", place["node"].get<int>(),
                                percentOf(place["probability"]), inArea(place)));
  if (!lines.empty()) return fmt::format("{}", fmt::join(lines, "\n"));
  const auto near = answers["near_spellings"].get<std::vector<std::string>>();
  return near.empty() ? "Nothing on the map means that."
                      : fmt::format("Nothing on the map means that. Did you mean {}?", fmt::join(near, ", "));
}

std::string routeText(const Json& route) {
  std::string text =
      fmt::format("From place {} to place {}: {:.1f} {}, over the places {}.", route["from"].get<int>(),
                  route["to"].get<int>(), route["cost"].get<double>(), route["unit"].get<std::string>(),
                  fmt::join(route["nodes"].get<std::vector<int>>(), ", "));
  if (const auto areas = route.find("areas"); areas != route.end() && !areas->empty()) {
    std::vector<std::string> names;
    for (const Json& area : *areas)
      if (const std::string name = nameIn(area); !name.empty()) names.push_back(name);
    text += fmt::format(" It leads through {}.", fmt::join(names, ", then "));
  }
  if (const auto pose = route.find("pose"); pose != route.end())
    text += fmt::format(" There stand at ({:.2f}, {:.2f}) m, yaw {:.2f} rad, {:.1f} m from {}.",
                        (*pose)["x"].get<double>(), (*pose)["y"].get<double>(), (*pose)["yaw"].get<double>(),
                        (*pose)["distance"].get<double>(), objectText(route["object"]));
  for (const Json& crossed : route["crossed"])
    text += fmt::format(" It crosses {}, which was to be avoided.", crossed["region"].get<std::string>());
  return text;
}

std::string namesText(const Json& references) {
  std::vector<std::string> names;
  for (const Json& reference : references) names.push_back(nameIn(reference));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string placeText(const Json& place) {
  const std::string name = nameIn(place);
  std::string text = fmt::format("Place {}{}{}.", place["node"].get<int>(),
                                 name.empty() ? "" : " (" + name + ")", inArea(place));
  std::vector<std::string> words, neighbors;
  for (const Json& word : place["words"])
    words.push_back(
        fmt::format("{} {:.0f} %", word["label"].get<std::string>(), percentOf(word["probability"])));
  for (const Json& neighbor : place["neighbors"])
    neighbors.push_back(std::to_string(neighbor["node"].get<int>()));
  text += fmt::format(" Seen there: {}.", fmt::join(words, ", "));
  if (!neighbors.empty()) text += fmt::format(" Ways lead to the places {}.", fmt::join(neighbors, ", "));
  if (!place["objects"].empty()) text += fmt::format(" Objects: {}.", namesText(place["objects"]));
  return text;
}

std::string areasText(const Json& areas) {
  if (areas["areas"].empty()) return "The map has no areas.";
  std::vector<std::string> lines;
  for (const Json& area : areas["areas"])
    lines.push_back(areaInShort(area) +
                    (area["objects"].empty() ? "" : "; objects: " + namesText(area["objects"])));
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::string changesText(const Json& changes) {
  std::vector<std::string> lines;
  for (const Json& change : changes["objects"]) {
    std::string line =
        fmt::format("{}: {}{}", change["kind"].get<std::string>(),
                    change["whole"].get<bool>() || change["name"].is_null() ? "" : "part of ",
                    change["name"].is_null() ? "something" : change["name"].get<std::string>());
    for (const char* end : {"from", "to"}) {
      if (!change.contains(end)) continue;
      const Json& at = change[end];
      const std::string area = nameIn(change[end + std::string("_area")]);
      line += fmt::format(", {} ({:.2f}, {:.2f}, {:.2f}) m{}", end, at[0].get<double>(), at[1].get<double>(),
                          at[2].get<double>(), area.empty() ? "" : " in " + area);
    }
    lines.push_back(line);
  }
  for (const Json& place : changes["places"])
    lines.push_back(fmt::format("place {} looks different", place["node"].get<int>()));
  if (lines.empty()) return "Nothing that was looked at again has changed.";
  return fmt::format("Since drive {}:\n{}", changes["since"].get<int>(), fmt::join(lines, "\n"));
}

struct McpTool {
  std::string name, title, description;
  Json properties;
  std::vector<std::string> required;
  Json (*ask)(const LiveQueries& queries, const ToolArguments& arguments);
  std::string (*inShort)(const Json& answer);

  Json schema() const {
    return {{"type", "object"},
            {"properties", properties},
            {"required", required},
            {"additionalProperties", false}};
  }
};

Json askFind(const LiveQueries& queries, const ToolArguments& arguments) {
  const int most = arguments.number("max", 1, 100).value_or(5);
  return queries.ask(arguments.text("words"), static_cast<std::size_t>(most));
}

Json askRoute(const LiveQueries& queries, const ToolArguments& arguments) {
  return queries.route({arguments.text("to"), arguments.number("from", 0, anyNumber),
                        arguments.texts("avoid"), arguments.texts("prefer")});
}

Json askPlace(const LiveQueries& queries, const ToolArguments& arguments) {
  return queries.place(*arguments.number("place", 0, anyNumber));
}

Json askChanges(const LiveQueries& queries, const ToolArguments& arguments) {
  return queries.changes(arguments.number("since", 1, anyNumber));
}

Json numberSchema(int least, const char* description) {
  return {{"type", "integer"}, {"minimum", least}, {"description", description}};
}

Json textsSchema(const char* description) {
  return {{"type", "array"}, {"items", {{"type", "string"}}}, {"description", description}};
}

const std::vector<McpTool>& allTools() {
  static const std::vector<McpTool> tools{
      {"find",
       "Find things and rooms",
       "Find objects, areas (rooms) and places of the robot's map by what they are: any English words, or "
       "the name that people gave. Answers have positions in meters and probabilities.",
       {{"words", {{"type", "string"}, {"description", "What to look for: \"coffee mug\", \"kitchen\""}}},
        {"max",
         {{"type", "integer"},
          {"minimum", 1},
          {"maximum", 100},
          {"default", 5},
          {"description", "Largest number of objects, and of places"}}}},
       {"words"},
       askFind,
       findText},
      {"where_am_i",
       "Where the robot is",
       "Say where the robot is now: the place of its map, the area (room), its pose, and how sure that is.",
       Json::object(),
       {},
       [](const LiveQueries& queries, const ToolArguments&) { return queries.where(); },
       [](const Json& found) { return found["sentence"].get<std::string>() + "."; }},
      {"route_to",
       "The way to something",
       "Plan the robot's way to a place (its number), an area or object (its name), or to what words mean. "
       "Answers have the places and areas along the way, its length in meters, and where to stand.",
       {{"to", {{"type", "string"}, {"description", "A place's number, a name, or words"}}},
        {"from", numberSchema(0, "The place to start from; left out: where the robot is")},
        {"avoid", textsSchema("Areas to go around where the detour is not too long")},
        {"prefer", textsSchema("Areas to go through where that is not too long")}},
       {"to"},
       askRoute,
       routeText},
      {"describe_place",
       "What is at a place",
       "Describe a place of the map: its room and area, the words of what was seen there, its neighbors, and "
       "objects.",
       {{"place", numberSchema(0, "The place's number")}},
       {"place"},
       askPlace,
       placeText},
      {"list_areas",
       "All areas",
       "List the areas (rooms) of the map with their names, sizes, positions and the objects in them.",
       Json::object(),
       {},
       [](const LiveQueries& queries, const ToolArguments&) { return queries.areas(); },
       areasText},
      {"list_changes",
       "What has changed",
       "List the things that were moved, are gone or are new, and the places that look different, since a "
       "drive of the robot began.",
       {{"since", numberSchema(1, "The number of the drive; left out: the last one")}},
       {},
       askChanges,
       changesText}};
  return tools;
}

/// Answer to tools/list.
Json mcpTools() {
  Json json = Json::array();
  for (const McpTool& tool : allTools())
    json.push_back({{"name", tool.name},
                    {"title", tool.title},
                    {"description", tool.description},
                    {"inputSchema", tool.schema()},
                    {"annotations", {{"readOnlyHint", true}, {"openWorldHint", false}}}});
  return json;
}

/// Nothing where there is no tool of that name. Throws Error: invalidInput where the arguments do not fit
/// its schema, else as the question does.
std::optional<ToolAnswer> callTool(const LiveQueries& queries, const std::string& name,
                                   const Arguments& arguments) {
  const auto tool = std::ranges::find(allTools(), name, &McpTool::name);
  if (tool == allTools().end()) return std::nullopt;
  const Json schema = tool->schema();
  Json found = tool->ask(queries, ToolArguments(arguments, schema));
  std::string text = tool->inShort(found);
  return ToolAnswer{std::move(found), std::move(text)};
}

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
