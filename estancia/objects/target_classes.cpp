// Target classes: reading and checking (object_model.hpp).
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "estancia/core/config.hpp"
#include "estancia/core/error.hpp"
#include "estancia/files/files.hpp"
#include "estancia/objects/object_model.hpp"

namespace estancia {
namespace {

std::vector<std::string> texts(ConfigFile& config, const toml::node& node) {
  std::vector<std::string> all;
  for (const toml::node& element : config.list(node)) all.push_back(config.text(element));
  if (all.empty())
    config.fail(node,
                fmt::format("`{}` is empty; leave it out if it is the name of the class", config.key()));
  return all;
}

TargetClasses::Class readClass(ConfigFile& config, const std::string& name, const toml::node& node) {
  const auto* table = node.as_table();
  if (table == nullptr) config.fail(node, fmt::format("`classes.{}` must be a table", name));
  TargetClasses::Class read{name, {name}, {name}};
  config.read(*table, {{"labels", false, "", [&](auto& n) { read.labels = texts(config, n); }},
                       {"categories", false, "", [&](auto& n) { read.categories = texts(config, n); }}});
  return read;
}

[[noreturn]] void refuse(const std::string& sentence) {
  throw Error(ErrorCode::invalidInput, sentence);
}

void requirePrintable(const TargetClasses::Class& target) {
  const std::string name = io::printable(target.name);
  if (target.name.empty()) refuse("a target class has no name; give it one");
  if (name != target.name) refuse(fmt::format("the name \"{}\" has control characters; remove them", name));
  if (target.labels.empty()) refuse(fmt::format("\"{}\" has no label; give one", name));
  for (const auto* texts : {&target.labels, &target.categories})
    for (const std::string& text : *texts)
      if (text.empty() || io::printable(text) != text)
        refuse(fmt::format("\"{}\" has a label or category that is empty or has control characters", name));
}

}  // namespace

void validate(const TargetClasses& targets) {
  if (targets.classes.empty()) refuse("there are no target classes; give at least one");
  std::set<std::string> names;
  std::set<std::pair<std::string, std::string>> owners;  // owners of categories
  for (const TargetClasses::Class& target : targets.classes) {
    requirePrintable(target);
    if (!names.insert(target.name).second)
      refuse(fmt::format("two target classes are called \"{}\"; rename one", target.name));
    for (const std::string& category : target.categories) {
      const auto found = owners.lower_bound({category, ""});
      if (found != owners.end() && found->first == category && found->second != target.name)
        refuse(fmt::format("the category \"{}\" belongs to both \"{}\" and \"{}\"; give it to one", category,
                           found->second, target.name));
      owners.emplace(category, target.name);
    }
  }
}

TargetClasses readTargetClasses(const std::filesystem::path& file) {
  ConfigFile config(file);
  const toml::table* tables = nullptr;
  config.read({{"classes", true, "a table [classes.NAME] for each class",
                [&](auto& n) { tables = &config.subtable(n); }}});
  // The parser sorts by name; people expect the order of the file.
  std::vector<std::pair<std::string, const toml::node*>> inOrder;
  for (const auto& [name, node] : *tables) inOrder.emplace_back(name.str(), &node);
  std::ranges::stable_sort(inOrder, {}, [](const auto& entry) {
    const auto& begin = entry.second->source().begin;
    return std::pair(begin.line, begin.column);
  });
  TargetClasses targets;
  const auto requireValid = [&](const toml::node& node) {
    try {
      validate(targets);
    } catch (const Error& error) {
      config.fail(node, error.what());
    }
  };
  for (const auto& [name, node] : inOrder) {
    targets.classes.push_back(readClass(config, name, *node));
    requireValid(*node);
  }
  requireValid(*tables);
  return targets;
}

TargetClasses targetClassesOf(const std::vector<std::string>& categories) {
  TargetClasses targets;
  for (const std::string& category : categories)
    if (targets.classOf(category) < 0) targets.classes.push_back({category, {category}, {category}});
  validate(targets);
  return targets;
}

std::vector<std::string> TargetClasses::names() const {
  std::vector<std::string> all;
  for (const Class& target : classes) all.push_back(target.name);
  return all;
}

int TargetClasses::classOf(const std::string& category) const {
  for (std::size_t c = 0; c < classes.size(); ++c)
    if (std::ranges::find(classes[c].categories, category) != classes[c].categories.end())
      return static_cast<int>(c);
  return -1;
}

}  // namespace estancia
