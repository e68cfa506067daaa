// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <algorithm>
#include <string>

#include "estancia/core/error.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/removed_options.hpp"

namespace estancia::python {
namespace {

std::string keyOf(const OptionGroup& group) {
  std::string key = group.name();
  std::replace(key.begin(), key.end(), '-', '_');
  return key;
}

/// In the form that the declarations parse.
std::string textOf(const py::handle& value, const std::string& path) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::hasattr(value, "__fspath__")) return py::str(value.attr("__fspath__")()).cast<std::string>();
  if (py::hasattr(value, "__index__")) return py::str(value.attr("__index__")()).cast<std::string>();
  if (py::hasattr(value, "__float__")) return py::repr(value.attr("__float__")()).cast<std::string>();
  if (py::isinstance<py::sequence>(value)) {  // lists are written with commas
    std::string list;
    for (const py::handle item : value) list += (list.empty() ? "" : ",") + textOf(item, path);
    return list;
  }
  fail(ErrorCode::invalidOption, "{} cannot be {}", path, py::repr(value).cast<std::string>());
}

void set(OptionGroup& group, const py::dict& given, const std::string& path) {
  for (const auto& [key, value] : given) {
    const auto name = py::str(key).cast<std::string>();
    const std::string full = path + name;
    if (value.is_none()) continue;
    if (py::isinstance<py::dict>(value)) {
      const auto inside = std::find_if(group.groups().begin(), group.groups().end(),
                                       [&](const OptionGroup& each) { return keyOf(each) == name; });
      const std::string known = group.name() + "." + name;
      if (const RemovedOption* removed = findRemovedOption(known);
          removed != nullptr && inside == group.groups().end())
        fail(ErrorCode::unknownName, "{}", describeRemoved(*removed, known));
      if (inside == group.groups().end())
        fail(ErrorCode::unknownName, "there is no group of options {}", full);
      set(*inside, py::reinterpret_borrow<py::dict>(value), full + ".");
    } else {
      if (name.find('.') != std::string::npos)
        fail(ErrorCode::unknownName, "the option {} is given as a dict in a dict", full);
      group.set(name, textOf(value, full));
    }
  }
}

const char* typeOf(const Option& option) {
  if (option.isFlag()) return "bool";
  if (option.isInteger()) return "int";
  return option.isNumber() ? "float" : "str";
}

py::dict describe(const Option& option) {
  py::list choices;
  for (const Choice& choice : option.choices()) choices.append(choice.name);
  py::dict described;
  described["key"] = option.key();
  described["type"] = typeOf(option);
  described["unit"] = option.unit();
  described["help"] = option.help();
  described["why"] = option.why();
  described["default"] =
      option.text().empty() && !option.automatic().empty() ? option.automatic() : option.text();
  described["accepted"] = option.accepted();
  described["choices"] = choices;
  return described;
}

}  // namespace

void setOptions(OptionGroup group, const py::dict& given) {
  set(group, given, "");
}

py::dict describeOptions(OptionGroup group) {
  py::list options, groups;
  for (const Option& option : group.options()) options.append(describe(option));
  for (const OptionGroup& inside : group.groups()) groups.append(describeOptions(inside));
  py::dict described;
  described["name"] = group.name();
  described["key"] = keyOf(group);
  described["help"] = group.help();
  described["options"] = options;
  described["groups"] = groups;
  return described;
}

}  // namespace estancia::python
