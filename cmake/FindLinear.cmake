# SPDX-License-Identifier: Apache-2.0
# Finds liblinear (liblinear-dev), which brings no CMake package: the target Linear::Linear.
find_library(Linear_LIBRARY linear)
find_path(Linear_INCLUDE_DIR linear.h)
mark_as_advanced(Linear_LIBRARY Linear_INCLUDE_DIR)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Linear REQUIRED_VARS Linear_LIBRARY Linear_INCLUDE_DIR REASON_FAILURE_MESSAGE "install liblinear-dev")
if(Linear_FOUND AND NOT TARGET Linear::Linear)
  add_library(Linear::Linear UNKNOWN IMPORTED)
  set_target_properties(Linear::Linear PROPERTIES IMPORTED_LOCATION "${Linear_LIBRARY}"
                                              INTERFACE_INCLUDE_DIRECTORIES "${Linear_INCLUDE_DIR}")
endif()
