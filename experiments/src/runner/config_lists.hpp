// Lists in the configurations of experiments.
#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/choice.hpp"
#include "estancia/core/config.hpp"

namespace estancia::experiments {

/// For a key that lists things, each as `read` has it: at least one, none twice.
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

/// For each(): one of these choices.
inline auto oneOf(const ConfigFile& config, const Choices& choices) {
  std::vector<std::string> names;
  names.reserve(choices.size());
  for (const Choice& choice : choices) names.push_back(choice.name);
  return oneOf(config, names);
}

/// For each(): one of these names, which are explained.
inline auto oneOf(const ConfigFile& config, const std::vector<std::pair<std::string, std::string>>& named) {
  std::vector<std::string> names;
  names.reserve(named.size());
  for (const auto& [name, explanation] : named) names.push_back(name);
  return oneOf(config, names);
}

}  // namespace estancia::experiments
