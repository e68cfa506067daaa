// estancia changes: what was moved, is gone or is new between drives.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/query/drives.hpp"
#include "estancia/world_query/changes.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;
using report::counted;

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
  if (world.objects.empty()) fmt::print("  the map has no objects: of things nothing can be told\n");
  for (const ObjectChange& change : changes.objects) {
    fmt::print("  {:<5}  {}", toString(change.kind), nameOf(change, world));
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
      ->check(wholeNumber(0))
      ->type_name("DRIVE");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia changes home.estancia\n"
              "  estancia changes home.estancia --since 3 --json");
  command->callback([arguments] {
    const Changes changes = findChanges(arguments->map, arguments->since);
    if (!arguments->json) return printText(*changes.world, changes);
    Json json{{"map", arguments->map}};
    json.update(toJson(changes));
    print(json);
  });
}

}  // namespace estancia::apps
