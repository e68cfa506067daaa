// Long calls: other Python threads run meanwhile, Ctrl-C interrupts, and exceptions of callbacks are raised.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <type_traits>
#include <utility>

#include "estancia/core/error.hpp"
#include "estancia/core/progress.hpp"

namespace estancia::python {

namespace py = pybind11;

/// While one exists, SIGINT asks the library to stop (estancia::interrupted()), and Python to raise
/// KeyboardInterrupt afterwards. A program that ignores the signal goes on doing so.
class InterruptWatch {
 public:
  InterruptWatch();
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;
};

/// Calls Python from C++ code that knows only Error: an exception of Python is kept until the longCall() of
/// this thread has ended, and Interrupted goes up in its place. Needs the interpreter's lock.
py::object callBack(const py::function& function, const py::tuple& arguments);

/// Raises what callBack() kept, if it kept something.
void raiseKept();
/// Raises the kept exception or, after Ctrl-C, KeyboardInterrupt.
void raiseKeptOrInterrupt();

/// Runs `work` without the interpreter's lock. Its result must be no Python object.
template <class Work>
auto longCall(Work&& work) {
  const InterruptWatch watch;
  const auto unlocked = [&] {
    const py::gil_scoped_release released;
    return std::forward<Work>(work)();
  };
  try {
    if constexpr (std::is_void_v<decltype(unlocked())>) {
      unlocked();
      raiseKept();  // where Interrupted is a usual end
    } else {
      auto result = unlocked();
      raiseKept();
      return result;
    }
  } catch (const Error&) {
    raiseKeptOrInterrupt();
    throw;
  }
}

/// Reports progress to a callable `(what, done, total)`, at most twenty times a second, and at the end of
/// each piece of work. True: a bar on stderr. None: no report. To be made and destroyed with the
/// interpreter's lock, and used in longCall().
std::unique_ptr<Progress> makeProgress(const py::object& callback);

/// Makes each Error an exception of estancia.errors.
void translateErrors();

}  // namespace estancia::python
