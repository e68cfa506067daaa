// estancia options: every parameter of the library that the command can set.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/removed_options.hpp"

namespace estancia::apps {
namespace {

using Json = nlohmann::ordered_json;

/// `path` ends with a dot, or is "" for the published group itself.
Json jsonOf(const PublishedGroup& published, const OptionGroup& group, const std::string& path = "") {
  Json json = Json::object();
  for (const Option& option : group.options()) {
    Json& entry = json[option.name()];
    entry["default"] = option.text();
    entry["unit"] = option.unit();
    entry["accepted"] = option.accepted();
    entry["help"] = option.help();
    entry["why"] = option.why();
    entry["flags"] = published.flagsOf(path + option.name());
  }
  for (const OptionGroup& inner : group.groups())
    json[inner.name()] = jsonOf(published, inner, path + inner.name() + ".");
  return json;
}

/// Prints the options whose path is or begins with `only`. Returns their number.
std::size_t printText(const PublishedGroup& published, const OptionGroup& group, const std::string& only,
                      const std::string& path = "") {
  std::size_t count = 0;
  for (const Option& option : group.options()) {
    const std::string name = path + option.name();
    if (!only.empty() && name != only && !name.starts_with(only + ".")) continue;
    const std::string value = option.automatic().empty() ? option.text() : option.automatic();
    const auto flags = published.flagsOf(name);
    fmt::print("{}.{} = {}\n    {}{} Accepts {}.{}\n", published.group.name(), name,
               value.empty() ? "(none)" : value, option.help(),
               option.why().empty() ? "" : " " + option.why(), option.accepted(),
               flags.empty() ? "" : fmt::format(" Flag: {}.", fmt::join(flags, ", ")));
    ++count;
  }
  for (const OptionGroup& inner : group.groups())
    count += printText(published, inner, only, path + inner.name() + ".");
  return count;
}

/// `which` is "", a group, or GROUP.NAME.
void run(const std::string& which, bool json) {
  const std::string name = which.substr(0, which.find('.'));
  const std::string only = name.size() < which.size() ? which.substr(name.size() + 1) : "";
  if (json && !only.empty())
    throw Error(ErrorCode::invalidOption, fmt::format("--json describes whole groups; give {}", name));
  Choices known;
  for (const PublishedGroup& published : publishedGroups())
    known.push_back({published.group.name(), published.group.help()});
  if (const RemovedOption* removed = findRemovedOption(which))
    throw Error(ErrorCode::unknownName, describeRemoved(*removed, which));
  if (!name.empty()) requireChoice("group of parameters", name, known);
  Json all = Json::object();
  for (const PublishedGroup& published : publishedGroups()) {
    const OptionGroup& group = published.group;
    if (!name.empty() && group.name() != name) continue;
    if (json) {
      all[group.name()] = {
          {"help", group.help()}, {"commands", published.commands}, {"options", jsonOf(published, group)}};
      continue;
    }
    if (only.empty())
      fmt::print("# {}: {} (of {})\n", group.name(), group.help(), fmt::join(published.commands, ", "));
    if (printText(published, group, only) == 0)
      throw Error(ErrorCode::unknownName,
                  fmt::format("{} has no parameter \"{}\"; see estancia options {}", name, only, name));
  }
  if (json) print(all);
}

}  // namespace

void addOptionsCommand(CLI::App& app) {
  struct Arguments {
    std::string which;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("options", "List all parameters: defaults, ranges, flags, and why to change them");
  command->add_option("GROUP", arguments->which, "Only this group, or this parameter: GROUP.NAME");
  addJsonOption(*command, arguments->json);
  addExamples(*command,
              "  estancia options\n"
              "  estancia options mapper\n"
              "  estancia options mapper.tau-join");
  command->callback([arguments] { run(arguments->which, arguments->json); });
}

}  // namespace estancia::apps
