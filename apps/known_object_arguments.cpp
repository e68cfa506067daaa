// SPDX-License-Identifier: Apache-2.0
#include "known_object_arguments.hpp"

#include <fmt/format.h>

#include "estancia/files/cloud_file.hpp"

namespace estancia::apps {

CLI::Option* KnownObjectArguments::addTo(CLI::App& command, const std::string& help) {
  CLI::Option* object = command.add_option("--object", words, help)->type_name("[NAME=]FILE");
  object->allow_extra_args(false);
  addUnitOption(command, "--object-unit", unit, "Unit of the coordinates in the clouds of --object");
  return object;
}

void addUnitOption(CLI::App& command, const std::string& name, std::string& unit, const std::string& help) {
  std::string choices;
  for (const Choice& choice : lengthUnits())
    choices += fmt::format("\n  {}: {}", choice.name, choice.explanation);
  command.add_option(name, unit, fmt::format("{}{}\nDefault: {}", help, choices, unit))->type_name("NAME");
}

}  // namespace estancia::apps
