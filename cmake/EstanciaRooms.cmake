# SPDX-License-Identifier: Apache-2.0
# One library a room of estancia/, so that whoever finds places by words does not link what recognizes objects:
#   estancia_room(NAME [LIGHT] [ROOMS room…] [INTERFACES room…] [LINKS library…])
# compiles estancia/NAME/*.cpp into estancia::NAME, which others find by find_package(estancia COMPONENTS NAME). ROOMS
# are those whose functions it calls, INTERFACES those of which it needs classes to derive from, and links nothing
# (docs/architecture.md). LINKS are what it uses inside; an installed
# static library needs them, too, so cmake/estanciaConfig.cmake.in finds their packages again: what is nothing but
# headers in .cpp files is a $<BUILD_INTERFACE:…>. LIGHT: see estancia_defaults().

# The public headers are what the umbrella header includes, and itself; script/lint checks that they need no others.
set(umbrella ${PROJECT_SOURCE_DIR}/estancia/estancia.hpp)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${umbrella})
file(STRINGS ${umbrella} ESTANCIA_HEADERS REGEX "^#include \"estancia/")
list(TRANSFORM ESTANCIA_HEADERS REPLACE "^#include \"(.*)\"$" "${PROJECT_SOURCE_DIR}/\\1")
set(ESTANCIA_ROOMS "")

# Below 1.0 a minor version may break, so the symbols of a shared library tell it: a program that was linked with 0.1
# does not start with 0.2, and the loader says why. The soname tells the major version.
set(node ESTANCIA_${PROJECT_VERSION_MAJOR})
if(PROJECT_VERSION_MAJOR EQUAL 0)
  string(APPEND node .${PROJECT_VERSION_MINOR})
endif()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/symbols.map CONTENT "${node} { *; };\n")

function(estancia_room room)
  cmake_parse_arguments(PARSE_ARGV 1 arg "LIGHT" "" "ROOMS;INTERFACES;LINKS")
  set(folder ${PROJECT_SOURCE_DIR}/estancia/${room})
  set(target estancia_${room})
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_module\\.cpp$") # cmake/EstanciaModules.cmake
  add_library(${target} ${sources})
  add_library(estancia::${room} ALIAS ${target})
  if(arg_LIGHT)
    set(light LIGHT)
  endif()
  estancia_defaults(${target} ${light})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${room}
                                             VERSION ${PROJECT_VERSION}
                                             SOVERSION ${PROJECT_VERSION_MAJOR}
                                             VERIFY_INTERFACE_HEADER_SETS ${PROJECT_IS_TOP_LEVEL}
                                             LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}
                                             INSTALL_RPATH $ORIGIN)
  target_compile_features(${target} PUBLIC cxx_std_20)
  # The file set brings the include folder, installs the headers, and lets CMake compile each of them alone
  # (target all_verify_interface_header_sets; script/test builds it).
  set(headers ${ESTANCIA_HEADERS})
  list(FILTER headers INCLUDE REGEX "^${folder}/")
  if(room STREQUAL core)
    list(APPEND headers ${PROJECT_SOURCE_DIR}/estancia/fwd.hpp ${PROJECT_SOURCE_DIR}/estancia/version.hpp)
  endif()
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${headers})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  list(TRANSFORM arg_ROOMS PREPEND estancia_ OUTPUT_VARIABLE rooms)
  target_link_libraries(${target} PUBLIC ${rooms} opencv_core PRIVATE ${arg_LINKS} fmt::fmt)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "SHARED_LIBRARY")
    target_link_options(${target} PRIVATE LINKER:--version-script=${PROJECT_BINARY_DIR}/symbols.map LINKER:-z,defs)
  endif()
  set(ESTANCIA_ROOMS ${ESTANCIA_ROOMS} ${room} PARENT_SCOPE)
  estancia_remember_needs(${room} "${arg_ROOMS}" "${arg_LINKS};fmt::fmt")
endfunction()

# What estanciaConfig.cmake needs to know of a room: the rooms below it, and the packages that a static library's users
# have to find, by the names before "::".
function(estancia_remember_needs room rooms links)
  set(below ${rooms})
  foreach(other IN LISTS rooms)
    get_property(more GLOBAL PROPERTY ESTANCIA_BELOW_${other})
    list(APPEND below ${more})
  endforeach()
  list(REMOVE_DUPLICATES below)
  set_property(GLOBAL PROPERTY ESTANCIA_BELOW_${room} ${below})
  list(FILTER links EXCLUDE REGEX "BUILD_INTERFACE")
  list(TRANSFORM links REPLACE "^SQLite::.*" "SQLite3")
  list(TRANSFORM links REPLACE "::.*" "")
  set_property(GLOBAL APPEND_STRING PROPERTY ESTANCIA_NEEDS "set(estancia_below_${room} ${below})\nset(estancia_needs_${room} ${links})\n")
endfunction()
