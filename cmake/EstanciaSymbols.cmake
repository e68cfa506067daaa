# SPDX-License-Identifier: Apache-2.0
# The soname tells the major version. Below 1.0 a minor version may break, so the symbols tell it, too: a program that
# was linked with 0.1 does not start with 0.2, and the loader says why.
get_target_property(type estancia TYPE)
if(type STREQUAL "SHARED_LIBRARY")
  set(node ESTANCIA_${PROJECT_VERSION_MAJOR})
  if(PROJECT_VERSION_MAJOR EQUAL 0)
    string(APPEND node .${PROJECT_VERSION_MINOR})
  endif()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/symbols.map CONTENT "${node} { *; };\n")
  target_link_options(estancia PRIVATE LINKER:--version-script=${PROJECT_BINARY_DIR}/symbols.map)
endif()
