// SPDX-License-Identifier: Apache-2.0
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

constexpr std::string_view threadsName = "threads";

/// All options named "threads" share the flag --threads.
void publishThreads(const OptionGroup& group, const std::string& path, PublishedGroup& published) {
  for (const Option& option : group.options())
    if (option.name() == threadsName) published.flags[path + option.name()].insert("--threads");
  for (const OptionGroup& inner : group.groups()) publishThreads(inner, path + inner.name() + ".", published);
}

void publish(const OptionGroup& group, const CLI::App& command) {
  auto& groups = registry();
  auto at = std::ranges::lower_bound(groups, group.name(), {}, [](const auto& p) { return p.group.name(); });
  if (at == groups.end() || at->group.name() != group.name()) at = groups.insert(at, {group, {}, {}});
  at->commands.push_back(pathOf(command));
  publishThreads(group, "", *at);
}

Choices namesOf(const std::vector<std::unique_ptr<OptionGroup>>& groups) {
  Choices names;
  for (const auto& group : groups) names.push_back({group->name(), ""});
  return names;
}

const char* typeOf(const Option& option) {
  if (!option.choices().empty()) return "NAME";
  return option.isInteger() ? "INT" : option.isNumber() ? "FLOAT" : "TEXT";
}

/// "How frames become places (mapper)": what it is, and how --set calls it.
std::string headingOf(const OptionGroup& group) {
  std::string heading = group.help();
  if (heading.ends_with('.')) heading.pop_back();
  return fmt::format("{} ({})", heading, group.name());
}

/// Help text of an option: sentence, accepted values or choices, default.
std::string helpOf(const Option& option) {
  std::string help = option.help();
  if (option.isNumber()) help += fmt::format("\nAccepts {}", option.accepted());
  for (const Choice& choice : option.choices())
    help +=
        fmt::format("\n  {}{}{}", choice.name, choice.explanation.empty() ? "" : ": ", choice.explanation);
  const std::string value = option.automatic().empty() ? option.text() : option.automatic();
  if (!option.isFlag() && !value.empty()) help += fmt::format("\nDefault: {}", value);
  return help;
}

const Option* findThreads(const OptionGroup& group) {
  for (const Option& option : group.options())
    if (option.name() == threadsName) return &option;
  for (const OptionGroup& inner : group.groups())
    if (const Option* option = findThreads(inner)) return option;
  return nullptr;
}

void setThreads(OptionGroup& group, const std::string& text) {
  if (Option* option = group.find(threadsName)) option->set(text, "--threads");
  for (OptionGroup& inner : group.groups()) setThreads(inner, text);
}

}  // namespace

const std::vector<PublishedGroup>& publishedGroups() {
  return registry();
}

DeclaredOptions::DeclaredOptions(CLI::App& command, OtherGroups others) : command_(command), others_(others) {
  const auto parameters = "Parameters";
  command
      .add_option("--config", config_,
                  "TOML file with a table for each group of parameters; see `estancia options`")
      ->type_name("FILE")
      ->group(parameters);
  command
      .add_option("--set", settings_,
                  "Set any parameter, over --preset and --config: GROUP.NAME=VALUE; see `estancia options`")
      ->type_name("GROUP.NAME=VALUE")
      ->allow_extra_args(false)
      ->group(parameters);
  command.parse_complete_callback([this] { parsed(); });
}

OptionGroup* DeclaredOptions::find(std::string_view name) const {
  const auto found = std::ranges::find_if(groups_, [&](const auto& group) { return group->name() == name; });
  return found == groups_.end() ? nullptr : found->get();
}

void DeclaredOptions::add(OptionGroup group, std::initializer_list<std::string_view> flags) {
  publish(group, command_);
  addThreads(group);
  const std::string name = group.name();
  groups_.push_back(std::make_unique<OptionGroup>(std::move(group)));
  addFlags(name, flags);
}

void DeclaredOptions::addFlags(std::string_view group, std::initializer_list<std::string_view> flags) {
  OptionGroup* kept = find(group);
  if (kept == nullptr) throw std::logic_error(fmt::format("there is no group {}", group));
  for (const std::string_view flag : flags) {
    const std::size_t equals = flag.find('='), dot = flag.rfind('.');
    if (equals != std::string_view::npos)
      addFlag(*kept, flag.substr(0, equals), std::string(flag.substr(equals + 1)));
    else
      addFlag(*kept, flag, std::string(dot == std::string_view::npos ? flag : flag.substr(dot + 1)));
  }
}

void DeclaredOptions::addFlag(OptionGroup& group, std::string_view path, std::string name) {
  const Option* option = group.find(path);
  if (option == nullptr) throw std::logic_error(fmt::format("{} has no option {}", group.name(), path));
  const bool isOn = option->isFlag() && option->text() == "true";
  if (isOn && option->name() == name) name = "no-" + name;
  if (!name.starts_with('-')) name = "--" + name;
  const Flag flag{name, group.name(), std::string(path)};
  std::ranges::find(registry(), group.name(), [](const auto& p) { return p.group.name(); })
      ->flags[flag.path]
      .insert(name);
  if (option->isFlag())
    command_
        .add_flag_function(
            name, [this, flag, isOn](std::int64_t) { given_.emplace_back(flag, isOn ? "false" : "true"); },
            (isOn ? "Switch off: " : "") + helpOf(*option))
        ->group(headingOf(group));
  else
    command_
        .add_option_function<std::string>(
            name, [this, flag](const std::string& text) { given_.emplace_back(flag, text); }, helpOf(*option))
        ->type_name(typeOf(*option))
        ->group(headingOf(group));
}

void DeclaredOptions::addThreads(const OptionGroup& group) {
  if (findThreads(group) == nullptr || command_.get_option_no_throw("--threads") != nullptr) return;
  command_.add_option("--threads", threads_, "Threads of the work; 0: one a usable core\nDefault: 0")
      ->type_name("INT");
}

void DeclaredOptions::addPreset(Choices presets, std::function<void(const std::string&)> apply) {
  presets_ = std::move(presets);
  applyPreset_ = std::move(apply);
  std::string help = "Parameters to begin with:";
  for (const Choice& preset : presets_) help += fmt::format("\n  {}: {}", preset.name, preset.explanation);
  command_.add_option("--preset", preset_, help)->type_name("NAME")->group("Parameters");
}

void DeclaredOptions::parsed() {
  if (!preset_.empty()) {
    requireChoice("preset", preset_, presets_);
    applyPreset_(preset_);
  }
  Targets targets;
  for (const auto& group : groups_) targets.push_back(group.get());
  apply(targets);
}

void DeclaredOptions::applyTo(OptionGroup group) const {
  apply({&group});
}

void DeclaredOptions::apply(const Targets& targets) const {
  applyConfig(targets);
  for (const std::string& setting : settings_) applySetting(setting, targets);
  for (OptionGroup* target : targets) {
    for (const auto& [flag, text] : given_)
      if (flag.group == target->name()) target->find(flag.path)->set(text, flag.name);
    if (!threads_.empty()) setThreads(*target, threads_);
    target->validate();
  }
}

void DeclaredOptions::applySetting(const std::string& setting, const Targets& targets) const {
  const std::size_t equals = setting.find('='), dot = setting.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot > equals)
    throw Error(ErrorCode::invalidOption,
                fmt::format("--set is \"{}\"; give GROUP.NAME=VALUE, such as {}.{}={}", setting,
                            groups_.front()->name(), groups_.front()->options().front().name(),
                            groups_.front()->options().front().text()));
  const std::string name = setting.substr(0, dot);
  if (find(name) == nullptr) requireChoice("group of parameters of this command", name, namesOf(groups_));
  for (OptionGroup* target : targets)
    if (target->name() == name)
      target->set(std::string_view(setting).substr(dot + 1, equals - dot - 1), setting.substr(equals + 1));
}

void DeclaredOptions::applyConfig(const Targets& targets) const {
  if (config_.empty()) return;
  ConfigFile config(config_);
  std::vector<ConfigFile::Key> keys;
  // One file may hold the parameters of all commands; those of others are checked, and have no effect here.
  for (const PublishedGroup& published : registry()) {
    const std::string& name = published.group.name();
    const auto own = std::ranges::find_if(targets, [&](const auto* group) { return group->name() == name; });
    OptionGroup* target = own == targets.end() ? nullptr : *own;
    std::string key = name;
    std::replace(key.begin(), key.end(), '-', '_');
    keys.push_back({key, false, "",
                    [&config, target, isOfOthers = find(name) == nullptr,
                     others = published.group](const toml::node& node) mutable {
                      if (target != nullptr)
                        config.read(config.subtable(node), *target);
                      else if (isOfOthers)
                        config.read(config.subtable(node), others);
                    }});
  }
  config.read(keys, others_ == OtherGroups::skip ? ConfigFile::Others::skip : ConfigFile::Others::refuse);
}

}  // namespace estancia::apps
