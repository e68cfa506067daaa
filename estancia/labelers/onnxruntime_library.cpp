// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/onnxruntime_library.hpp"

#ifdef ESTANCIA_ONNXRUNTIME_LIBRARY  // cmake/EstanciaOnnxruntime.cmake

#include <dlfcn.h>
#include <fmt/format.h>
#include <onnxruntime_c_api.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "estancia/labelers/model.hpp"

namespace estancia::onnxruntime {
namespace fs = std::filesystem;
namespace {

constexpr auto fileName = "libonnxruntime.so";

/// Opens one file. It stays open until the process ends, as its threads may.
Library open(const fs::path& file) {
  Library library;
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    library.problem = dlerror();
    return library;
  }
  const auto getBase = reinterpret_cast<const OrtApiBase* (*)()>(dlsym(handle, "OrtGetApiBase"));
  if (getBase == nullptr) {
    library.problem = fmt::format("{} is no ONNX Runtime", file.string());
    return library;
  }
  library.version = getBase()->GetVersionString();
  // A version that it does not know makes ONNX Runtime write to stderr; it knows those up to its own.
  int major = 0, minor = 0;
  std::sscanf(library.version.c_str(), "%d.%d", &major, &minor);
  if (major == 1 && minor >= ORT_API_VERSION) library.api = getBase()->GetApi(ORT_API_VERSION);
  if (library.api == nullptr)
    library.problem = fmt::format("{} is ONNX Runtime {}, where 1.{} or a later 1.x is needed", file.string(),
                                  library.version, ORT_API_VERSION);
  return library;
}

std::vector<fs::path> candidates() {
  std::error_code unreadable;  // another user's home: as if it were not there
  if (const char* given = std::getenv("ESTANCIA_ONNXRUNTIME"); given != nullptr && *given != '\0') {
    const fs::path path = given;
    if (!fs::is_directory(path, unreadable)) return {path};
    return {fs::is_directory(path / "lib", unreadable) ? path / "lib" / fileName : path / fileName};
  }
  std::vector<fs::path> files;
  for (const fs::path& file :
       {fs::path(ESTANCIA_ONNXRUNTIME_LIBRARY), modelHome().parent_path() / "onnxruntime/lib" / fileName})
    if (fs::is_regular_file(file, unreadable)) files.push_back(file);
  files.emplace_back("libonnxruntime.so.1");
  files.emplace_back(fileName);
  return files;
}

Library find() {
  std::string problem;
  for (const fs::path& file : candidates()) {
    Library library = open(file);
    if (library.api != nullptr) return library;
    if (problem.empty()) problem = library.problem;
  }
  return {nullptr, "",
          fmt::format(
              "ONNX Runtime cannot be used: {}; run estancia-fetch (script/bootstrap in the source), or name "
              "the library in ESTANCIA_ONNXRUNTIME",
              problem)};
}

}  // namespace

const Library& library() {
  static const Library found = find();
  return found;
}

}  // namespace estancia::onnxruntime

#else

namespace estancia::onnxruntime {

const Library& library() {
  static const Library none{nullptr, "",
                            "this Estancia was built without ONNX Runtime; run script/bootstrap and build it "
                            "again"};
  return none;
}

}  // namespace estancia::onnxruntime

#endif
