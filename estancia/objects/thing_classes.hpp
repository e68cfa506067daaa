// Thing classes: which categories of a home's truth are small things, furniture or fixtures, and what labels
// name them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/core/config.hpp"
#include "estancia/core/vocabulary.hpp"

namespace estancia {

struct ThingClasses {
  /// Things of this class belong to the building: whether a map has them counts neither way.
  static constexpr const char* fixture = "fixture";

  /// By category of instances.csv; all others are `otherClass`.
  std::map<std::string, std::string> classOf = {};
  std::string otherClass = "thing";
  /// By category: what labels call its things.
  std::map<std::string, std::vector<std::string>> words = {};

  /// The class of a category.
  const std::string& of(const std::string& category) const;
  /// The labels that name a thing of the category; empty where the vocabulary has none. See findLabels().
  std::vector<std::string> labelsOf(const std::string& category, const Vocabulary& vocabulary) const;
};

/// The keys `other` and `classes` of a configuration; `classes` need not be there where it is not `required`.
/// No class may have one of the `reserved` names.
std::vector<ConfigFile::Key> thingClassKeys(ConfigFile& config, ThingClasses& classes, bool required,
                                            const std::set<std::string_view>& reserved = {});

/// Reads TOML: `other = CLASS`, `[classes]` with a list of categories by class, `[words]` with a list of
/// labels by category; each may be missing. Throws Error `FILE:LINE: …` (malformedFile) on unknown or wrong
/// keys, a category in two classes, a category without words.
ThingClasses readThingClasses(const std::filesystem::path& file);

}  // namespace estancia
