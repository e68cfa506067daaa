// estancia changes: what was moved, is gone or is new between drives.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/report/text.hpp"
#include "estancia/world/changes.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

Json pointJson(const cv::Point3d& p) {
  return {p.x, p.y, p.z};
}

Json changeJson(const WorldMap& world, const ObjectChange& change) {
  const WorldObject& thing = *world.findObject(change.now ? *change.now : *change.before);
  Json json{{"kind", toString(change.kind)},
            {"name", thing.displayName()},
            {"before", change.before ? Json(*change.before) : Json()},
            {"now", change.now ? Json(*change.now) : Json()},
            {"emptiness", change.emptiness}};
  if (change.before) {
    json["from"] = pointJson(change.from);
    json["last_seen"] = world.places.frames.at(change.lastBefore).name;
  }
  if (change.now) {
    json["to"] = pointJson(change.to);
    json["first_seen"] = world.places.frames.at(change.firstNow).name;
  }
  return json;
}

std::string placeOf(const WorldMap& world, int object, const cv::Point3d& at) {
  const WorldArea* area = world.findArea(world.findObject(object)->area);
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) m{}", at.x, at.y, at.z,
                     area == nullptr ? "" : fmt::format(" in {}", area->displayName()));
}

void printText(const WorldMap& world, const Changes& changes) {
  const Drive& drive = world.places.drives[changes.since];
  fmt::print("since drive {}{}: {}\n", changes.since, drive.name.empty() ? "" : " (" + drive.name + ")",
             counted(changes.objects.size(), "changed object"));
  for (const ObjectChange& change : changes.objects) {
    const WorldObject& thing = *world.findObject(change.now ? *change.now : *change.before);
    fmt::print("  {:<6} {:<24}", toString(change.kind), thing.displayName());
    if (change.before) fmt::print(" from {}", placeOf(world, *change.before, change.from));
    if (change.now) fmt::print(" to {}", placeOf(world, *change.now, change.to));
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
      ->type_name("DRIVE");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia changes home.estancia\n"
              "  estancia changes home.estancia --since 3 --json");
  command->callback([arguments] {
    const Changes changes = findChanges(arguments->map, arguments->since);
    const WorldMap world = readWorld(arguments->map);
    if (!arguments->json) return printText(world, changes);
    Json list = Json::array();
    for (const ObjectChange& change : changes.objects) list.push_back(changeJson(world, change));
    print(Json{{"map", arguments->map}, {"since", changes.since}, {"objects", std::move(list)}});
  });
}

}  // namespace estancia::apps
