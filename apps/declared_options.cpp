#include "declared_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"

namespace estancia::apps {
namespace {

std::vector<PublishedGroup>& registry() {
  static std::vector<PublishedGroup> groups;
  return groups;
}

std::string pathOf(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent == nullptr || parent->get_parent() == nullptr ? command.get_name()
                                                              : pathOf(*parent) + " " + command.get_name();
}

void publish(const OptionGroup& group, const CLI::App& command) {
  auto& groups = registry();
  const auto known = std::find_if(groups.begin(), groups.end(),
                                  [&](const auto& p) { return p.group.name() == group.name(); });
  if (known == groups.end())
    groups.push_back({group, {pathOf(command)}});
  else
    known->commands.push_back(pathOf(command));
}

Choices namesOfGroups() {
  Choices names;
  for (const PublishedGroup& published : registry()) names.push_back({published.group.name(), ""});
  return names;
}

const char* typeOf(const Option& option) {
  if (!option.choices().empty()) return "NAME";
  return option.isInteger() ? "INT" : option.isNumber() ? "FLOAT" : "TEXT";
}

}  // namespace

std::string helpOf(const Option& option) {
  std::string help = option.help();
  if (!option.unit().empty()) help += fmt::format(" [{}]", option.unit());
  for (const Choice& choice : option.choices())
    help +=
        fmt::format("\n  {}{}{}", choice.name, choice.explanation.empty() ? "" : ": ", choice.explanation);
  const std::string value = option.automatic().empty() ? option.text() : option.automatic();
  if (!option.isFlag() && !value.empty()) help += fmt::format("\nDefault: {}", value);
  return help;
}

const std::vector<PublishedGroup>& publishedGroups() {
  return registry();
}

DeclaredOptions::DeclaredOptions(CLI::App& command) : command_(command) {
  const auto parameters = "Parameters";
  command
      .add_option("--config", config_,
                  "TOML file with a table for each group of parameters; see `estancia options`")
      ->type_name("FILE")
      ->group(parameters);
  command
      .add_option("--set", settings_, "Set any parameter: GROUP.NAME=VALUE; `estancia options` lists them")
      ->type_name("GROUP.NAME=VALUE")
      ->allow_extra_args(false)
      ->group(parameters);
  command.parse_complete_callback([this] { apply(); });
}

void DeclaredOptions::add(OptionGroup group, std::initializer_list<std::string_view> flags) {
  publish(group, command_);
  OptionGroup& kept = *groups_.emplace_back(std::make_unique<OptionGroup>(std::move(group)));
  for (const std::string_view flag : flags) {
    const std::size_t equals = flag.find('='), dot = flag.rfind('.');
    const std::string_view path = flag.substr(0, equals);
    const std::string_view name = equals != std::string_view::npos ? flag.substr(equals + 1)
                                  : dot != std::string_view::npos  ? flag.substr(dot + 1)
                                                                   : flag;
    addFlag(kept, path, "--" + std::string(name));
  }
}

void DeclaredOptions::addFlag(OptionGroup& group, std::string_view path, const std::string& flag) {
  Option* option = group.find(path);
  if (option == nullptr) throw std::logic_error(fmt::format("{} has no option {}", group.name(), path));
  const auto* entry =
      flags_.emplace_back(std::make_unique<std::pair<std::string, Option*>>(flag, option)).get();
  const auto keep = [this, entry](const std::string& text) { given_.emplace_back(entry, text); };
  const auto heading = group.help();
  if (option->isFlag()) {
    const bool isOn = option->text() == "true";
    command_
        .add_flag_function(
            isOn ? "--no-" + flag.substr(2) : flag,
            [keep, isOn](std::int64_t) { keep(isOn ? "false" : "true"); }, helpOf(*option))
        ->group(heading);
  } else {
    command_.add_option_function<std::string>(flag, keep, helpOf(*option))
        ->type_name(typeOf(*option))
        ->group(heading);
  }
}

void DeclaredOptions::apply() {
  readConfig();
  for (const std::string& setting : settings_) {
    const std::size_t equals = setting.find('='), dot = setting.find('.');
    if (equals == std::string::npos || dot == std::string::npos || dot > equals)
      throw Error(ErrorCode::invalidOption,
                  fmt::format("--set is \"{}\"; give GROUP.NAME=VALUE, such as gng.seed=3", setting));
    const std::string name = setting.substr(0, dot);
    const auto group =
        std::find_if(groups_.begin(), groups_.end(), [&](const auto& g) { return g->name() == name; });
    if (group == groups_.end()) {
      Choices known;
      for (const auto& one : groups_) known.push_back({one->name(), ""});
      requireChoice("group of parameters of this command", name, known);
    }
    (*group)->set(std::string_view(setting).substr(dot + 1, equals - dot - 1), setting.substr(equals + 1));
  }
  for (const auto& [entry, text] : given_) entry->second->set(text, entry->first);
  for (const auto& group : groups_) group->validate();
}

void DeclaredOptions::readConfig() {
  if (config_.empty()) return;
  ConfigFile config(config_);
  std::vector<ConfigFile::Key> keys;
  // One file may hold the parameters of all commands; those of others are left alone.
  for (const Choice& name : namesOfGroups()) {
    const auto own =
        std::find_if(groups_.begin(), groups_.end(), [&](const auto& g) { return g->name() == name.name; });
    OptionGroup* group = own == groups_.end() ? nullptr : own->get();
    std::string key = name.name;
    std::replace(key.begin(), key.end(), '-', '_');
    keys.push_back({key, false, "", [&config, group](const toml::node& node) {
                      if (group != nullptr) config.read(config.subtable(node), *group);
                    }});
  }
  config.read(keys);
}

}  // namespace estancia::apps
