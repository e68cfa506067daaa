// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/thing_classes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/label_words.hpp"

namespace estancia {

const std::string& ThingClasses::of(const std::string& category) const {
  const auto known = classOf.find(category);
  return known == classOf.end() ? otherClass : known->second;
}

std::vector<std::string> ThingClasses::labelsOf(const std::string& category,
                                                const Vocabulary& vocabulary) const {
  std::vector<std::string> labels;
  const auto named = words.find(category);
  if (named == words.end()) return labels;
  for (const std::string& word : named->second)
    for (const std::size_t label : findLabels(vocabulary, word))
      if (std::ranges::find(labels, vocabulary[label]) == labels.end()) labels.push_back(vocabulary[label]);
  return labels;
}

std::vector<ConfigFile::Key> thingClassKeys(ConfigFile& config, ThingClasses& classes, bool required,
                                            const std::set<std::string_view>& reserved) {
  const auto requireOwnName = [&config, reserved](const toml::node& node, std::string_view name) {
    if (name.empty() || reserved.contains(name))
      config.fail(node, fmt::format("a class cannot be called \"{}\"; choose another name", name));
  };
  const auto read = [&config, &classes, requireOwnName](const toml::node& node) {
    for (const auto& [name, categories] : config.subtable(node)) {
      requireOwnName(categories, name.str());
      for (const toml::node& category : config.list(categories))
        if (!classes.classOf.emplace(config.text(category), std::string(name.str())).second)
          config.fail(category, fmt::format("{} has a class already", config.text(category)));
    }
  };
  return {{"other", false, "the class of all other categories",
           [&config, &classes, requireOwnName](const toml::node& node) {
             classes.otherClass = config.text(node);
             requireOwnName(node, classes.otherClass);
           }},
          {"classes", required, "a list of categories by class", read}};
}

ThingClasses readThingClasses(const std::filesystem::path& file) {
  ConfigFile config(file);
  ThingClasses classes;
  std::vector<ConfigFile::Key> keys = thingClassKeys(config, classes, false);
  keys.push_back({"words", false, "a list of labels by category", [&](const toml::node& node) {
                    for (const auto& [name, labels] : config.subtable(node)) {
                      std::vector<std::string>& words = classes.words[std::string(name.str())];
                      for (const toml::node& label : config.list(labels)) words.push_back(config.text(label));
                      if (words.empty())
                        config.fail(labels, fmt::format("{} has no words; leave it out", name.str()));
                    }
                  }});
  config.read(keys);
  return classes;
}

}  // namespace estancia
