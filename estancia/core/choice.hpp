// Choice: methods, presets and formats that are picked by name, with one line of explanation each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace estancia {

/// One entry of a registry.
struct Choice {
  std::string name;
  std::string explanation;
  bool operator==(const Choice&) const = default;
};
using Choices = std::vector<Choice>;

/// "a, b, c".
std::string namesOf(const Choices& choices);

/// Throws Error (unknownName) unless one of `choices` has this name; `what` names their kind ("filter"). The
/// sentence lists the known names.
void requireChoice(std::string_view what, std::string_view name, const Choices& choices);

}  // namespace estancia
