// Plugins: functions of modules that bring large libraries along and are opened when first needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia {

struct ModuleFunction {
  void* address = nullptr;
  /// Why there is no address.
  std::string problem;
};

/// `name` in `module`, a file that lies beside this library or command, in `fromBin` relative to them, in a
/// folder beside them that is called as the last of `fromBin`, or where the loader looks. The module stays
/// open until the process ends, as its threads may. `global` shows its symbols to modules opened after it.
ModuleFunction moduleFunction(const std::string& module, const std::string& fromBin, const char* name,
                              bool global = false);

/// Its address. Throws Error (missingDependency) where there is none; its sentence begins with what cannot be
/// done without ("videos cannot be read"), and names the Debian package that has the module.
void* getModuleFunction(const std::string& module, const std::string& fromBin, const char* name,
                        const char* consequence, const char* package = "libestancia0");

}  // namespace estancia
