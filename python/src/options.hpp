// Options: keyword arguments of Python, set and checked by the declarations that the command uses, too.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "estancia/core/options.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace estancia::python {

namespace py = pybind11;

/// Sets each option that `given` names by its key; a dict is for a group inside: {"method": "gng", "gng":
/// {"neurons": 3000}}. None takes the default. Throws Error (unknownName, invalidOption).
void setOptions(OptionGroup group, const py::dict& given);

/// The options of one struct, with those that are given; the others have their defaults.
template <class Options>
Options optionsFrom(const py::dict& given, Options options = {}) {
  setOptions(declare(options), given);
  validate(options);
  return options;
}

/// Does so where the library asks for a change of its defaults, without the interpreter's lock; `given` must
/// outlive it.
inline auto changing(const py::dict& given) {
  return [&given](auto& options) {
    const py::gil_scoped_acquire locked;
    setOptions(declare(options), given);
  };
}

/// What is declared, for the typed declarations of Python: {"name", "help", "options": [{"key", "type",
/// "unit", "help", "why", "default", "accepted", "choices"}], "groups": [...]}.
py::dict describeOptions(OptionGroup group);

}  // namespace estancia::python
