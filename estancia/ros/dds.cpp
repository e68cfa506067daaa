// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/dds.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/core/module_function.hpp"

namespace estancia::ros {
namespace {

/// Beyond it the ports of a domain end (RTPS 2.3, 9.6.1.1).
constexpr int lastDomain = 232;

}  // namespace

std::unique_ptr<DdsNode> makeDdsNode(int domain) {
  if (domain < 0 || domain > lastDomain)
    fail(ErrorCode::invalidOption, "{} is no domain of ROS 2; choose one from 0 to {} (ROS_DOMAIN_ID)",
         domain, lastDomain);
#ifdef ESTANCIA_DDS_MODULE  // cmake/EstanciaModules.cmake
  // After an exception the next call tries again.
  static const auto make = reinterpret_cast<DdsNode* (*)(int)>(
      getModuleFunction(ESTANCIA_DDS_MODULE, ESTANCIA_DDS_FROM_BIN, "estanciaMakeDdsNode",
                        "topics of ROS 2 cannot be read or written", "estancia-ros2"));
  return std::unique_ptr<DdsNode>(make(domain));
#else
  fail(ErrorCode::missingDependency,
       "topics of ROS 2 cannot be read or written: this Estancia was built without Fast DDS; install the "
       "package libfastrtps-dev (script/bootstrap does) and build again");
#endif
}

}  // namespace estancia::ros
