// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/module_function.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace {
namespace fs = std::filesystem;

/// Where both the build tree and an installation have modules.
std::vector<std::string> candidates(const std::string& module, const std::string& fromBin) {
  std::vector<std::string> files;
  Dl_info self{};
  std::error_code unreadable;
  if (dladdr(reinterpret_cast<const void*>(&moduleFunction), &self) != 0 && self.dli_fname != nullptr) {
    const fs::path file = fs::read_symlink("/proc/self/exe", unreadable);
    for (const fs::path& from : {fs::path(self.dli_fname).parent_path(), file.parent_path()})
      for (const fs::path& folder : {from, from / fs::path(fromBin).filename(), from / fromBin})
        // A relative name would be looked for in the folder that the program is run in, whoever's it is.
        if (folder.is_absolute() && fs::is_regular_file(folder / module, unreadable))
          files.push_back((folder / module).string());
  }
  files.push_back(module);
  return files;
}

}  // namespace

ModuleFunction moduleFunction(const std::string& module, const std::string& fromBin, const char* name,
                              bool global) {
  ModuleFunction found;
  for (const std::string& file : candidates(module, fromBin)) {
    void* handle = dlopen(file.c_str(), RTLD_NOW | (global ? RTLD_GLOBAL : RTLD_LOCAL));
    if (handle != nullptr) found.address = dlsym(handle, name);
    if (found.address != nullptr) return found;
    if (found.problem.empty()) found.problem = dlerror();
  }
  return found;
}

void* getModuleFunction(const std::string& module, const std::string& fromBin, const char* name,
                        const char* consequence, const char* package) {
  const ModuleFunction found = moduleFunction(module, fromBin, name);
  if (found.address == nullptr)
    fail(ErrorCode::missingDependency,
         "{}: {} cannot be opened ({}); keep it beside the program or in {} from there, or install the "
         "package {} (in the source: script/bootstrap, and build again)",
         consequence, module, found.problem, fromBin, package);
  return found.address;
}

}  // namespace estancia
