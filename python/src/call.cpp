// SPDX-License-Identifier: Apache-2.0
#include "call.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <exception>
#include <mutex>
#include <string>

#include "estancia/core/take_interrupt.hpp"

namespace estancia::python {
namespace {

std::mutex watchMutex;
int watches = 0;
bool handles = false;
struct sigaction handlerBefore {};

/// What a callback of this thread's longCall() has raised.
thread_local std::exception_ptr kept;

void onInterrupt(int /*signal*/) {
  requestInterrupt();
  PyErr_SetInterrupt();
}

class CallbackProgress final : public Progress {
 public:
  explicit CallbackProgress(py::function callback) : callback_(std::move(callback)) {}

  void begin(const std::string& what, std::size_t total, std::size_t done) override {
    end();
    what_ = what;
    total_ = total;
    done_ = done;
    active_ = true;
    tell();
  }
  void advance(std::size_t count) override {
    done_ += count;
    if (active_ && Clock::now() - told_ >= std::chrono::milliseconds(50)) tell();
  }
  void end() override {
    if (!active_) return;
    active_ = false;
    if (toldDone_ != done_) tell();
  }

 private:
  using Clock = std::chrono::steady_clock;

  void tell() {
    told_ = Clock::now();
    toldDone_ = done_;
    const py::gil_scoped_acquire locked;
    callBack(callback_, py::make_tuple(what_, done_, total_));
  }

  py::function callback_;
  std::string what_;
  std::size_t total_ = 0, done_ = 0, toldDone_ = 0;
  bool active_ = false;
  Clock::time_point told_;
};

}  // namespace

InterruptWatch::InterruptWatch() {
  const std::lock_guard lock(watchMutex);
  if (watches++ > 0) return;
  sigaction(SIGINT, nullptr, &handlerBefore);
  handles = handlerBefore.sa_handler != SIG_IGN && handlerBefore.sa_handler != SIG_DFL;
  if (!handles) return;
  struct sigaction ours {};
  ours.sa_handler = onInterrupt;
  sigaction(SIGINT, &ours, nullptr);
}

InterruptWatch::~InterruptWatch() {
  const std::lock_guard lock(watchMutex);
  if (--watches > 0) return;
  takeInterrupt();  // KeyboardInterrupt reports it from here on
  if (handles) sigaction(SIGINT, &handlerBefore, nullptr);
}

py::object callBack(const py::function& function, const py::tuple& arguments) {
  try {
    return function(*arguments);
  } catch (py::error_already_set&) {
    kept = std::current_exception();
    throw Interrupted("a function of Python raised an exception");
  }
}

void raiseKept() {
  if (kept) std::rethrow_exception(std::exchange(kept, nullptr));
}

void raiseKeptOrInterrupt() {
  raiseKept();
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

std::unique_ptr<Progress> makeProgress(const py::object& callback) {
  if (callback.is_none()) return std::make_unique<Progress>();
  if (py::isinstance<py::bool_>(callback)) return makeStderrProgress();
  return std::make_unique<CallbackProgress>(callback);
}

void translateErrors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& e) {
      const py::object error =
          py::module_::import("estancia.errors").attr("_error_of")(std::string(nameOf(e.code())), e.what());
      PyErr_SetObject(py::type::of(error).ptr(), error.ptr());
    }
  });
}

}  // namespace estancia::python
