# SPDX-License-Identifier: Apache-2.0
# ONNX Runtime, the faster engine, is optional. Only its headers are compiled against; the library is opened when it is
# first needed (label/onnxruntime_library.hpp), so that nothing that links Estancia depends on one version of it in
# somebody's home. Taken are, in this order: the folder ESTANCIA_ONNXRUNTIME, an installed package, script/bootstrap's.
set(ESTANCIA_ONNXRUNTIME "" CACHE STRING "Folder of ONNX Runtime with include/ and lib/; OFF to build without it")

function(estancia_use_onnxruntime target)
  if(ESTANCIA_ONNXRUNTIME STREQUAL "OFF")
    return()
  endif()
  set(folders ${ESTANCIA_ONNXRUNTIME})
  if(NOT folders)
    find_package(onnxruntime CONFIG QUIET)
    if(TARGET onnxruntime::onnxruntime)
      get_target_property(folders onnxruntime::onnxruntime INTERFACE_INCLUDE_DIRECTORIES)
      list(TRANSFORM folders REPLACE "/include.*" "")
    endif()
    if(DEFINED ENV{ESTANCIA_HOME})
      list(APPEND folders $ENV{ESTANCIA_HOME}/onnxruntime)
    else()
      list(APPEND folders $ENV{HOME}/.local/share/estancia/onnxruntime)
    endif()
  endif()
  set(inside NO_DEFAULT_PATH NO_CACHE)
  find_path(headers onnxruntime_cxx_api.h PATHS ${folders} ${inside}
            PATH_SUFFIXES include include/onnxruntime include/onnxruntime/core/session)
  find_library(library onnxruntime PATHS ${folders} ${inside} PATH_SUFFIXES lib lib64 lib/${CMAKE_LIBRARY_ARCHITECTURE})
  if(headers AND library)
    file(STRINGS ${headers}/onnxruntime_c_api.h version REGEX "^#define ORT_API_VERSION ")
    string(REGEX REPLACE "[^0-9]" "" version "${version}")
  endif()
  if(headers AND library AND version GREATER_EQUAL 13)
    message(STATUS "ONNX Runtime: API ${version}, ${library}")
    set_source_files_properties(
      estancia/label/onnxruntime_library.cpp estancia/label/onnxruntime_engine.cpp
      PROPERTIES COMPILE_DEFINITIONS ESTANCIA_ONNXRUNTIME_LIBRARY="${library}" COMPILE_OPTIONS "-isystem;${headers}")
    target_link_libraries(${target} PRIVATE ${CMAKE_DL_LIBS})
  elseif(ESTANCIA_ONNXRUNTIME)
    message(FATAL_ERROR "${ESTANCIA_ONNXRUNTIME} holds no ONNX Runtime 1.13 or later (include/ and lib/)")
  else()
    message(STATUS "ONNX Runtime: none found, OpenCV runs the networks; script/bootstrap fetches it")
  endif()
endfunction()
estancia_use_onnxruntime(estancia)
