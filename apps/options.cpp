// estancia options: every parameter of the library that the command can set.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common.hpp"
#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/core/error.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/recognition/recognition_options.hpp"
#include "estancia/topology/localizer.hpp"
#include "estancia/topology/mapper.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const OptionGroup& group) {
  Json json = Json::object();
  for (const Option& option : group.options()) {
    Json& entry = json[option.name()];
    entry["default"] = option.text();
    entry["unit"] = option.unit();
    entry["accepted"] = option.accepted();
    entry["help"] = option.help();
    entry["why"] = option.why();
  }
  for (const OptionGroup& inner : group.groups()) json[inner.name()] = toJson(inner);
  return json;
}

void printText(const OptionGroup& group, const std::string& path) {
  for (const Option& option : group.options()) {
    const std::string value = option.automatic().empty() ? option.text() : option.automatic();
    fmt::print("{}.{} = {}\n    {}{} Accepts {}.\n", path, option.name(), value.empty() ? "(none)" : value,
               option.help(), option.why().empty() ? "" : " " + option.why(), option.accepted());
  }
  for (const OptionGroup& inner : group.groups()) printText(inner, path + "." + inner.name());
}

/// The options of a struct with their defaults.
template <class Options>
OptionGroup groupOf() {
  static Options defaults;
  return declare(defaults);
}

std::vector<OptionGroup> groupsOfTheLibrary() {
  return {groupOf<MapperOptions>(),     groupOf<LocalizerOptions>(), groupOf<ZoneOptions>(),
          groupOf<FilterOptions>(),     groupOf<ClusterOptions>(),   groupOf<RgbdOptions>(),
          groupOf<RecognitionOptions>()};
}

void run(const std::string& name, bool json) {
  Json all = Json::object();
  Choices known;
  for (const OptionGroup& group : groupsOfTheLibrary()) {
    known.push_back({group.name(), group.help()});
    if (!name.empty() && group.name() != name) continue;
    if (json)
      all[group.name()] = toJson(group);
    else
      fmt::print("# {}\n", group.help()), printText(group, group.name());
  }
  if (!name.empty()) requireChoice("group of parameters", name, known);
  if (json) print(all);
}

}  // namespace

void addOptionsCommand(CLI::App& app) {
  struct Arguments {
    std::string group;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("options", "List all parameters: defaults, ranges, and why to change them");
  command->add_option("GROUP", arguments->group, "Only this group, such as mapper or recognition");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia options\n"
              "  estancia options mapper");
  command->callback([arguments] { run(arguments->group, arguments->json); });
}

}  // namespace estancia::apps
