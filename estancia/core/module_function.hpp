// Functions of our own modules, which bring large libraries along and are opened when they are first needed.
#pragma once

#include <string>

namespace estancia {

struct ModuleFunction {
  void* address = nullptr;
  std::string problem;  ///< where there is none: why
};

/// `name` in `module`, a file that lies beside this library or command, in `fromBin` relative to them, or
/// where the loader looks. The module stays open until the process ends, as its threads may. `global` shows
/// its symbols to what is opened after it.
ModuleFunction moduleFunction(const std::string& module, const std::string& fromBin, const char* name,
                              bool global = false);

}  // namespace estancia
