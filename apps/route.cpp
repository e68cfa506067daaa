// estancia route: the way to a place or to a word.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <charconv>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/topology/map_json.hpp"
#include "estancia/topology/places.hpp"
#include "estancia/topology/route.hpp"

namespace estancia::apps {
namespace {

struct RouteArguments {
  explicit RouteArguments(CLI::App& command) : declared(command) {}
  std::string map, to;
  int from = 0;
  RouteOptions options;
  DeclaredOptions declared;
  bool json = false;
};

/// `--to 7` names a node, `--to coffee` what should be there.
std::optional<int> nodeNumber(const std::string& text) {
  int id = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (problem != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return id;
}

void run(const RouteArguments& arguments) {
  const TopologicalMap map = readMap(arguments.map);
  std::optional<WordRoute> found;
  Route route;
  try {
    if (const auto node = nodeNumber(arguments.to)) {
      route = getRoute(map, arguments.from, *node, arguments.options);
    } else {
      found = routeToWords(map, arguments.from, arguments.to, arguments.options);
      route = found->route;
    }
  } catch (const NoAnswerError& why) {
    if (arguments.json)
      print({{"from", arguments.from},
             {"to", nullptr},
             {"nodes", nlohmann::json::array()},
             {"why", why.what()}});
    else
      fmt::print("No way: {}\n", why.what());
    throw NoAnswer{};
  }
  const std::vector<Place> places = placesOf(map);
  if (arguments.json) return print(found ? toJson(arguments.to, *found, map) : toJson(route));
  if (found && !found->goal.isLikely())
    spdlog::warn("no place is likely to hold \"{}\"; this is the most probable one", printable(arguments.to));
  if (found)
    fmt::print("\"{}\" is at place {} ({:.1f} %)\n",
               found->goal.room.empty() ? shortLabel(map.vocabulary[found->goal.label]) : found->goal.room,
               found->goal.node, 100 * found->goal.probability);
  std::vector<std::string> steps;
  for (const int node : route.nodes) {
    const std::string room = places[indexOf(map, node)].displayRoom();
    steps.push_back(room.empty() ? std::to_string(node) : fmt::format("{} ({})", node, room));
  }
  fmt::print(
      "{}\n{}\n", fmt::join(steps, " → "),
      route.metric ? fmt::format("{:.1f} m", route.cost) : fmt::format("{:.0f} transitions", route.cost));
}

}  // namespace

void addRouteCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("route", "Find the way to a place, or to where a word is");
  auto arguments = std::make_shared<RouteArguments>(*command);
  command->add_option("MAP", arguments->map, "The map file")->required();
  command->add_option("--from", arguments->from, "The place to start from (a node number)")->required();
  command->add_option("--to", arguments->to, "A node number, or words to look for")->required();
  arguments->declared.add(declare(arguments->options), {"bidirectional=one-way", "tolerance"});
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia route home.estancia --from 0 --to umbrella\n"
              "  estancia route home.estancia --from 3 --to 12 --json");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace estancia::apps
