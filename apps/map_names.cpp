// SPDX-License-Identifier: Apache-2.0
#include "map_names.hpp"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "common.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/figures/text.hpp"
#include "estancia/world_file/world_map.hpp"

namespace estancia::apps {
namespace {

using NameCounts = std::map<std::string, std::size_t>;

/// "3 of 14 objects recognized: chair (2), desk"
std::string lineOf(const NameCounts& counts, std::size_t objects, const char* what) {
  std::size_t all = 0;
  std::string names;
  for (const auto& [name, count] : counts) {
    all += count;
    names += (names.empty() ? ": " : ", ") + printable(name) + (count > 1 ? fmt::format(" ({})", count) : "");
  }
  return fmt::format("  {} of {} {}{}\n", all, report::counted(objects, "object"), what, names);
}

}  // namespace

ObjectNamers::ObjectNamers(const std::vector<ModelFile>& known, const std::string& model) {
  if (!known.empty()) known_ = std::make_shared<const KnownObjects>(known);
  if (model.empty()) return;
  model_ = readObjectModel(model);
  digest_ = sha256OfFile(model);
}

void ObjectNamers::giveTo(WorldMapper& mapper) const {
  if (known_) mapper.recognize(known_);
  if (model_) mapper.classify(*model_, digest_);
}

std::string ObjectNamers::addNames(const std::string& map, nlohmann::ordered_json& summary) const {
  if (!known_ && !model_) return "";
  const WorldMap world = readWorld(map);
  NameCounts recognized, shapes;
  for (const WorldObject& object : world.objects) {
    if (object.known) ++recognized[object.known->name];
    if (const std::string* name = object.shapeClass()) ++shapes[*name];
  }
  if (known_) summary["recognized"] = recognized;
  if (model_) summary["shapes"] = shapes;
  return (known_ ? lineOf(recognized, world.objects.size(), "recognized") : "") +
         (model_ ? lineOf(shapes, world.objects.size(), "of a class by shape") : "");
}

}  // namespace estancia::apps
