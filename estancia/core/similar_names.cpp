// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/similar_names.hpp"

#include <fmt/ranges.h>

#include <map>

#include "estancia/core/ascii.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {
namespace {

std::string normalized(std::string_view name) {
  return lowerCase(std::string(trimmed(name)));
}

}  // namespace

std::string_view trimmed(std::string_view name) {
  constexpr std::string_view blanks = " \t\r\n";
  const auto first = name.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return name.substr(first, name.find_last_not_of(blanks) + 1 - first);
}

bool isSimilar(std::string_view one, std::string_view other) {
  return one != other && normalized(one) == normalized(other);
}

std::vector<std::vector<std::string>> similarNames(const std::set<std::string>& names) {
  std::map<std::string, std::vector<std::string>> groups;
  for (const std::string& name : names) groups[normalized(name)].push_back(name);
  std::vector<std::vector<std::string>> similar;
  for (auto& [key, group] : groups)
    if (group.size() > 1) similar.push_back(std::move(group));
  return similar;
}

std::vector<std::string> warningsOfSimilarRooms(const std::set<std::string>& rooms) {
  std::vector<std::string> warnings;
  for (const auto& group : similarNames(rooms)) {
    std::vector<std::string> quoted;
    for (const std::string& name : group) quoted.push_back(fmt::format("\"{}\"", printable(name)));
    warnings.push_back(fmt::format(
        "the rooms {} differ only in case or blanks and are taken for {} rooms; if they are one, give them "
        "one name",
        fmt::join(quoted, " and "), group.size()));
  }
  return warnings;
}

}  // namespace estancia
