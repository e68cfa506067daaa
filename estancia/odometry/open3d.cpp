// SPDX-License-Identifier: Apache-2.0
#include "estancia/odometry/open3d.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/core/module_function.hpp"

namespace estancia::odometry {

#ifdef ESTANCIA_OPEN3D_MODULE  // cmake/EstanciaModules.cmake

namespace {

const Open3d& openModule() {
  const ModuleFunction open =
      moduleFunction(ESTANCIA_OPEN3D_MODULE, ESTANCIA_OPEN3D_FROM_BIN, "estanciaOpen3d");
  if (open.address != nullptr) return *reinterpret_cast<const Open3d* (*)()>(open.address)();
  fail(ErrorCode::missingDependency,
       "odometry needs Open3D, which cannot be opened: {}; install the package libopen3d-dev "
       "(script/bootstrap does) and Estancia again",
       open.problem);
}

}  // namespace

const Open3d& open3d() {
  static const Open3d& opened = openModule();
  return opened;
}

#else

const Open3d& open3d() {
  throw Error(
      ErrorCode::missingDependency,
      "this Estancia was built without Open3D, which odometry needs; install the package libopen3d-dev "
      "(script/bootstrap does) and build again, or take poses from elsewhere by --poses");
}

#endif

}  // namespace estancia::odometry
