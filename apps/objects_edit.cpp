// estancia objects list, name, delete: people correct the objects of a map.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <string>

#include "command_tree.hpp"
#include "common.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_query/world_json.hpp"
#include "objects.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;

struct ObjectArguments {
  std::string map, object, name;
  bool json = false;
};

/// A command on MAP, with `--json`.
CLI::App* addCommand(CLI::App& objects, const char* name, const char* help, ObjectArguments& arguments) {
  CLI::App* command = objects.add_subcommand(name, help);
  command->add_option("MAP", arguments.map, "The map file")->required();
  addJsonOption(*command, arguments.json);
  return command;
}

/// Corrections may number them anew.
void printObjects(const ObjectArguments& arguments) {
  const WorldMap world = readWorld(arguments.map);
  if (!arguments.json)
    fmt::print("{}: {}\n", printable(arguments.map), report::counted(world.objects.size(), "object"));
  Json objects = Json::array();
  for (const WorldObject& object : world.objects) {
    const WorldArea* area = world.findArea(object.area);
    if (!arguments.json)
      fmt::print("  {:>3}  {:<32} {:>6.2f} {:>6.2f} {:>6.2f}  {}\n", object.id, object.displayName(),
                 object.center.x, object.center.y, object.center.z,
                 area == nullptr ? "" : "in " + area->displayName());
    objects.push_back(toJson(object, world));
  }
  if (arguments.json) print(Json{{"map", arguments.map}, {"objects", objects}});
}

}  // namespace

void addObjectsList(CLI::App& objects) {
  auto arguments = std::make_shared<ObjectArguments>();
  CLI::App* command = addCommand(objects, "list",
                                 "List the objects of a map: numbers, names, where they are [m]", *arguments);
  addExamples(*command, "  estancia objects list home.estancia");
  command->callback([arguments] { printObjects(*arguments); });
}

void addObjectsName(CLI::App& objects) {
  auto arguments = std::make_shared<ObjectArguments>();
  CLI::App* command = addCommand(objects, "name", "Name an object of a map", *arguments);
  command->add_option("OBJECT", arguments->object, "Its number, or the name it has")->required();
  command
      ->add_option("NAME", arguments->name,
                   "What people call it, kept when the objects are found again; \"\" takes the name away")
      ->type_name(textOrNothing)
      ->required();
  addExamples(*command, "  estancia objects name home.estancia 12 \"Ana's mug\"");
  command->callback([arguments] {
    nameObject(arguments->map, arguments->object, arguments->name);
    printObjects(*arguments);
  });
}

void addObjectsDelete(CLI::App& objects) {
  auto arguments = std::make_shared<ObjectArguments>();
  CLI::App* command = addCommand(
      objects, "delete", "Take out of a map what is no object; it stays away when objects are found again",
      *arguments);
  command->add_option("OBJECT", arguments->object, "Its number, or the name it has")->required();
  addExamples(*command, "  estancia objects delete home.estancia 12");
  command->callback([arguments] {
    deleteObject(arguments->map, arguments->object);
    printObjects(*arguments);
  });
}

}  // namespace estancia::apps
