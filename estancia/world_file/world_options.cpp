// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/world_options.hpp"

#include <sstream>
#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {

std::string toString(const WorldLayers& layers) {
  std::string names = "places";
  if (layers.zones) names += ",zones";
  if (layers.areas) names += ",areas";
  if (layers.objects) names += ",objects";
  return names;
}

WorldLayers layersFrom(const std::string& names) {
  WorldLayers layers{false, false, false};
  std::istringstream rest(names);
  for (std::string name; std::getline(rest, name, ',');)
    if (name == "zones")
      layers.zones = true;
    else if (name == "areas")
      layers.areas = true;
    else if (name == "objects")
      layers.objects = true;
    else if (name != "places")
      fail(ErrorCode::unknownName, "a map has no layer \"{}\"; it has places, zones, areas and objects",
           printable(name));
  return layers;
}

OptionGroup declare(WorldOptions& options) {
  OptionGroup group("world", "How a drive becomes areas and objects.");
  group
      .add("layers",
           Option::Text{[&options] { return options.layers ? toString(*options.layers) : std::string(); },
                        [&options](const std::string& names) { options.layers = layersFrom(names); }},
           "What the map holds: places,zones,areas,objects, some of them")
      .automatic("all that the drive allows");
  group.add("view-shift", &options.viewShift, "How far the camera moves to a new view.")
      .range(0, 10)
      .unit("m")
      .why("A robot that stands still sees nothing new.");
  group.add("view-turn", &options.viewTurn, "How far the camera turns to a new view.")
      .range(0, 180)
      .unit("degrees");
  group
      .add("crops", &options.crops,
           "Objects that are labeled for each frame: new ones and better views first.")
      .range(0, 1000)
      .why("Each costs as much as the frame itself.");
  group.add(declare(options.areas));
  group.add(declare(options.segments));
  group.add(declare(options.objects));
  OptionGroup odometry = declare(options.odometry);
  std::erase_if(odometry.options(), [](const Option& o) { return o.name().starts_with("odom-"); });
  group.add(std::move(odometry));
  return group;
}

}  // namespace estancia
