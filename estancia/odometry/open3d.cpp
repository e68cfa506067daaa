#include "estancia/odometry/open3d.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "estancia/core/error.hpp"

namespace estancia::odometry {

#ifdef ESTANCIA_OPEN3D_MODULE  // cmake/EstanciaOpen3d.cmake

namespace {
namespace fs = std::filesystem;

/// Beside this library or command, where both the build tree and an installation have it; else where the
/// loader looks.
std::vector<std::string> candidates() {
  std::vector<std::string> files;
  Dl_info self{};
  std::error_code unreadable;
  if (dladdr(reinterpret_cast<const void*>(&open3d), &self) != 0 && self.dli_fname != nullptr) {
    const fs::path file = fs::read_symlink("/proc/self/exe", unreadable);
    for (const fs::path& from : {fs::path(self.dli_fname).parent_path(), file.parent_path()})
      for (const fs::path& folder : {from, from / ESTANCIA_OPEN3D_FROM_BIN})
        if (fs::is_regular_file(folder / ESTANCIA_OPEN3D_MODULE, unreadable))
          files.push_back((folder / ESTANCIA_OPEN3D_MODULE).string());
  }
  files.emplace_back(ESTANCIA_OPEN3D_MODULE);
  return files;
}

const Open3d& openModule() {
  std::string problem;
  for (const std::string& file : candidates()) {
    // It stays open until the process ends, as its threads may.
    void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    const auto get =
        handle == nullptr ? nullptr : reinterpret_cast<const Open3d* (*)()>(dlsym(handle, "estanciaOpen3d"));
    if (get != nullptr) return *get();
    if (problem.empty()) problem = dlerror();
  }
  throw Error(
      fmt::format("odometry needs Open3D, which cannot be opened: {}; install the package libopen3d-dev "
                  "(script/bootstrap does) and Estancia again",
                  problem));
}

}  // namespace

const Open3d& open3d() {
  static const Open3d& opened = openModule();
  return opened;
}

#else

const Open3d& open3d() {
  throw Error(
      "this Estancia was built without Open3D, which odometry needs; install the package libopen3d-dev "
      "(script/bootstrap does) and build again, or take poses from elsewhere by --poses");
}

#endif

}  // namespace estancia::odometry
