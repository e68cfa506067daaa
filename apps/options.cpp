// estancia options: every parameter of the library that the command can set.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common.hpp"
#include "estancia/core/error.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;

Json jsonOf(const OptionGroup& group) {
  Json json = Json::object();
  for (const Option& option : group.options()) {
    Json& entry = json[option.name()];
    entry["default"] = option.text();
    entry["unit"] = option.unit();
    entry["accepted"] = option.accepted();
    entry["help"] = option.help();
    entry["why"] = option.why();
  }
  for (const OptionGroup& inner : group.groups()) json[inner.name()] = jsonOf(inner);
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

void run(const std::string& name, bool json) {
  Json all = Json::object();
  Choices known;
  for (const auto& [group, commands] : publishedGroups()) {
    known.push_back({group.name(), group.help()});
    if (!name.empty() && group.name() != name) continue;
    if (json)
      all[group.name()] = {{"help", group.help()}, {"commands", commands}, {"options", jsonOf(group)}};
    else
      fmt::print("# {}: {} (of {})\n", group.name(), group.help(), fmt::join(commands, ", ")),
          printText(group, group.name());
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
