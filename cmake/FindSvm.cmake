# SPDX-License-Identifier: Apache-2.0
# Finds libsvm (libsvm-dev), which brings no CMake package: the target Svm::Svm.
find_library(Svm_LIBRARY svm)
find_path(Svm_INCLUDE_DIR libsvm/svm.h)
mark_as_advanced(Svm_LIBRARY Svm_INCLUDE_DIR)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Svm REQUIRED_VARS Svm_LIBRARY Svm_INCLUDE_DIR REASON_FAILURE_MESSAGE "install libsvm-dev")
if(Svm_FOUND AND NOT TARGET Svm::Svm)
  add_library(Svm::Svm UNKNOWN IMPORTED)
  set_target_properties(Svm::Svm PROPERTIES IMPORTED_LOCATION "${Svm_LIBRARY}"
                                              INTERFACE_INCLUDE_DIRECTORIES "${Svm_INCLUDE_DIR}")
endif()
