// estancia changes: what was moved, is gone or is new between drives.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/report/text.hpp"
#include "estancia/topology/drives.hpp"
#include "estancia/world/changes.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

Json pointJson(const cv::Point3d& p) {
  return {p.x, p.y, p.z};
}

/// The object that it is or was a part of; nullptr where that is none.
const WorldObject* thingOf(const WorldMap& world, const ObjectChange& change) {
  const auto object = change.now ? change.now : change.before;
  return object ? world.findObject(*object) : nullptr;
}

std::string nameOf(const WorldMap& world, const ObjectChange& change) {
  const WorldObject* thing = thingOf(world, change);
  if (thing == nullptr) return "something";
  return (change.isWhole ? "" : "part of ") + thing->displayName();
}

Json changeJson(const WorldMap& world, const ObjectChange& change) {
  const auto number = [](const std::optional<int>& object) { return object ? Json(*object) : Json(); };
  const WorldObject* thing = thingOf(world, change);
  Json json{{"kind", toString(change.kind)},    {"name", thing ? Json(thing->displayName()) : Json()},
            {"whole", change.isWhole},          {"object_before", number(change.before)},
            {"object_now", number(change.now)}, {"area_m2", change.area}};
  if (change.kind != ObjectChange::Kind::appeared) {
    json["from"] = pointJson(change.from);
    json["last_seen"] = world.places.frames.at(change.lastBefore).name;
  }
  if (change.kind != ObjectChange::Kind::gone) {
    json["to"] = pointJson(change.to);
    json["first_seen"] = world.places.frames.at(change.firstNow).name;
  }
  return json;
}

Json changeJson(const PlaceChange& change) {
  Json words = Json::array();
  for (const PlaceChange::Word& word : change.words)
    words.push_back({{"label", word.label}, {"before", word.before}, {"now", word.now}});
  return {{"node", change.node}, {"distance", change.distance}, {"words", std::move(words)}};
}

std::string where(const WorldMap& world, const cv::Point3d& at) {
  const WorldArea* area =
      world.plan ? world.findArea(areaAt(*world.plan, world.plan->floor.position({at.x, at.y, at.z}), 0.5))
                 : nullptr;
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) m{}", at.x, at.y, at.z,
                     area == nullptr ? "" : fmt::format(", {}", area->displayName()));
}

void printText(const WorldMap& world, const Changes& changes) {
  fmt::print("since {}: {}, {}\n", describeDrive(world.places, changes.since),
             counted(changes.objects.size(), "changed thing"),
             counted(changes.places.size(), "changed place"));
  for (const ObjectChange& change : changes.objects) {
    fmt::print("  {:<5}  {}", toString(change.kind), nameOf(world, change));
    if (change.kind != ObjectChange::Kind::appeared) fmt::print("  from {}", where(world, change.from));
    if (change.kind != ObjectChange::Kind::gone) fmt::print("  to {}", where(world, change.to));
    fmt::print("\n");
  }
  for (const PlaceChange& change : changes.places) {
    fmt::print("  place {} ({:.2f} tau_join):", change.node, change.distance);
    for (const PlaceChange::Word& word : change.words)
      fmt::print(" {} {:.0f} → {:.0f} %", shortLabel(word.label), 100 * word.before, 100 * word.now);
    fmt::print("\n");
  }
}

}  // namespace

void addChangesCommand(CLI::App& app) {
  struct Arguments {
    std::string map;
    std::optional<std::size_t> since;
    bool json = false;
  };
  CLI::App* command =
      app.add_subcommand("changes", "Tell what was moved, is gone or is new since a drive of a map");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("MAP", arguments->map, "The map file")->required();
  command
      ->add_option(
          "--since", arguments->since,
          "Number of the first drive that counts as now, of `estancia drives`; the last one by default")
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("DRIVE");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia changes home.estancia\n"
              "  estancia changes home.estancia --since 3 --json");
  command->callback([arguments] {
    const Changes changes = findChanges(arguments->map, arguments->since);
    const WorldMap world = readWorld(arguments->map);
    if (!arguments->json) return printText(world, changes);
    Json objects = Json::array(), places = Json::array();
    for (const ObjectChange& change : changes.objects) objects.push_back(changeJson(world, change));
    for (const PlaceChange& change : changes.places) places.push_back(changeJson(change));
    print(Json{{"map", arguments->map},
               {"since", changes.since},
               {"objects", std::move(objects)},
               {"places", std::move(places)}});
  });
}

}  // namespace estancia::apps
