// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/options.hpp"

#include <algorithm>

#include "estancia/core/fail.hpp"

namespace estancia {

std::string namesOf(const Choices& choices) {
  std::string names;
  for (const Choice& choice : choices) names += (names.empty() ? "" : ", ") + choice.name;
  return names;
}

void requireChoice(std::string_view what, std::string_view name, const Choices& choices) {
  if (std::any_of(choices.begin(), choices.end(), [&](const Choice& c) { return c.name == name; })) return;
  fail(ErrorCode::unknownName, "unknown {} \"{}\"; known: {}", what, name, namesOf(choices));
}

}  // namespace estancia
