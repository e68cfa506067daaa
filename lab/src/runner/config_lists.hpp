// Configuration lists: keys of TOML that hold several values.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/config.hpp"
#include "estancia/core/options.hpp"

namespace estancia::experiments {

/// Keys of one table, from several places.
inline std::vector<ConfigFile::Key> together(std::vector<ConfigFile::Key> keys,
                                             const std::vector<ConfigFile::Key>& more) {
  keys.insert(keys.end(), more.begin(), more.end());
  return keys;
}

/// The keys of declared options; the group lives as long as they do.
inline std::vector<ConfigFile::Key> keysOf(ConfigFile& config, OptionGroup group) {
  const auto kept = std::make_shared<OptionGroup>(std::move(group));
  std::vector<ConfigFile::Key> keys = config.keysOf(*kept);
  for (ConfigFile::Key& key : keys)
    key.use = [kept, use = std::move(key.use)](const toml::node& node) { use(node); };
  return keys;
}

/// Keys of which one must be there.
inline std::vector<ConfigFile::Key> requiring(const std::string& name, std::vector<ConfigFile::Key> keys) {
  for (ConfigFile::Key& key : keys)
    if (key.name == name) key.required = true;
  return keys;
}

/// The first of these keys that is in the table; null without one.
inline const toml::node* firstOf(const toml::table& table, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (const toml::node* node = table.get(name)) return node;
  return nullptr;
}

/// For a key that lists items, each as `read` has it: at least one, none twice.
template <class T, class Read>
auto each(const ConfigFile& config, std::vector<T>& to, const Read& read) {
  return [&config, &to, read](const toml::node& node) {
    to.clear();
    for (const toml::node& element : config.list(node)) {
      to.push_back(read(element));
      if (std::count(to.begin(), to.end(), to.back()) > 1)
        config.fail(element, fmt::format("`{}` names {} twice", config.key(), to.back()));
    }
    if (to.empty())
      config.fail(node, fmt::format("`{}` is empty; leave it out for the default", config.key()));
  };
}

/// For each(): one of these names.
inline auto oneOf(const ConfigFile& config, const std::vector<std::string>& names) {
  std::vector<std::pair<std::string, std::string>> choices;
  choices.reserve(names.size());
  for (const std::string& name : names) choices.emplace_back(name, name);
  return [&config, choices](const toml::node& node) { return config.choice(node, choices); };
}

/// For each(): one of these names, each with its explanation (Choices).
template <class Named>
auto oneOf(const ConfigFile& config, const std::vector<Named>& named) {
  std::vector<std::string> names;
  names.reserve(named.size());
  for (const auto& [name, explanation] : named) names.push_back(name);
  return oneOf(config, names);
}

}  // namespace estancia::experiments
