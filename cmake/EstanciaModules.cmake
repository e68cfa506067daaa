# SPDX-License-Identifier: Apache-2.0
# What needs large libraries that most commands do not is a module of its own, opened when it is first needed
# (core/module_function.hpp): nobody else loads these libraries, and nobody who links Estancia links them. OpenCV's
# image codecs (GDAL) and its video input (FFmpeg, GStreamer) are two thirds of what a start of the command would load.
option(ESTANCIA_DDS "Read and write topics of ROS 2, where Fast DDS is installed" ON)
option(ESTANCIA_MPI "Run experiments and merge maps under mpirun, where Open MPI is installed" ON)
# They are no libraries to link, so they lie in a folder of their own. It changes its name with the shared library.
set(ESTANCIA_MODULE_DIR ${CMAKE_INSTALL_LIBDIR}/estancia-${PROJECT_VERSION_MAJOR})

# Makes the module `target` of ${opener}_module.cpp and the libraries that follow, for `owner`. ${opener}.cpp knows
# its file as ${TARGET}_MODULE, and as ${TARGET}_FROM_BIN the folder where it is installed, relative to the command.
function(estancia_add_module target owner opener)
  add_library(${target} MODULE ${PROJECT_SOURCE_DIR}/${opener}_module.cpp)
  estancia_defaults(${target})
  set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${ESTANCIA_MODULE_DIR}
                                             CXX_VISIBILITY_PRESET hidden)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE ${ARGN})
  add_dependencies(${owner} ${target})
  file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR}/estancia-${PROJECT_VERSION_MAJOR})
  string(TOUPPER ${target} name)
  set_source_files_properties(
    ${opener}.cpp
    PROPERTIES COMPILE_DEFINITIONS "${name}_MODULE=\"$<TARGET_FILE_NAME:${target}>\";${name}_FROM_BIN=\"${from_bin}\"")
  install(TARGETS ${target} LIBRARY DESTINATION ${ESTANCIA_MODULE_DIR})
  if(NOT target STREQUAL estancia_mpi) # what lies in a wheel of Python
    set_property(GLOBAL APPEND PROPERTY ESTANCIA_MODULES ${target})
  endif()
endfunction()

# The modules lie in a folder beside the shared libraries. A program that links the static ones looks for them where
# Estancia is installed, or, if it builds Estancia as a part of itself, where they were built.
function(estancia_find_modules target)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    target_link_options(${target} INTERFACE
                        "$<INSTALL_INTERFACE:LINKER:-rpath,$<INSTALL_PREFIX>/${ESTANCIA_MODULE_DIR}>")
    if(NOT PROJECT_IS_TOP_LEVEL) # our own programs lie in bin/, beside
      target_link_options(${target} INTERFACE "$<BUILD_INTERFACE:LINKER:-rpath,${PROJECT_BINARY_DIR}/${ESTANCIA_MODULE_DIR}>")
    endif()
  endif()
endfunction()

# Processes on several machines talk through Open MPI, once mpirun has started the command.
function(estancia_use_mpi owner opener)
  if(ESTANCIA_MPI)
    find_package(MPI QUIET COMPONENTS C)
  endif()
  if(NOT TARGET MPI::MPI_C)
    message(STATUS "Open MPI: none found, experiments and merges will run on one machine; script/bootstrap installs it")
    return()
  endif()
  estancia_add_module(estancia_mpi ${owner} ${opener} MPI::MPI_C)
endfunction()

# Topics of ROS 2 come through Fast DDS.
function(estancia_use_dds owner opener)
  if(ESTANCIA_DDS)
    find_package(fastrtps QUIET)
  endif()
  if(NOT TARGET fastrtps)
    message(STATUS "Fast DDS: none found, there will be no topics of ROS 2; script/bootstrap installs it")
    return()
  endif()
  estancia_add_module(estancia_dds ${owner} ${opener} fastrtps fmt::fmt)
  file(GLOB parts CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${opener}_*_module.cpp)
  # It links nothing of Estancia, as whoever opens it may have that linked in; so it holds what it throws.
  target_sources(estancia_dds PRIVATE ${parts} ${PROJECT_SOURCE_DIR}/${opener}_names.cpp
                                      ${PROJECT_SOURCE_DIR}/estancia/core/fail.cpp
                                      ${PROJECT_SOURCE_DIR}/estancia/core/error.cpp
                                      ${PROJECT_SOURCE_DIR}/estancia/core/printable.cpp)
endfunction()
