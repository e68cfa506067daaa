// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/module_function.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>
#include <vector>

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
      for (const fs::path& folder : {from, from / fromBin})
        if (fs::is_regular_file(folder / module, unreadable)) files.push_back((folder / module).string());
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

}  // namespace estancia
