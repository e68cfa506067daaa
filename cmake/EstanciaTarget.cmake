# SPDX-License-Identifier: Apache-2.0
# Warnings, optimization, hardening and sanitizers of one of our own targets. `LIGHT`: code without hot loops, which
# compiles a third faster with little optimization.
function(estancia_defaults target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wnon-virtual-dtor -Woverloaded-virtual -fopenmp-simd)
  set(unity $<BOOL:$<TARGET_PROPERTY:${target},UNITY_BUILD>>)
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    # In a unity build the names of one file are shadowed by the next one's. Not each `omp simd` is a promise.
    target_compile_options(${target} PRIVATE $<$<NOT:${unity}>:-Wshadow> -Wno-pass-failed -Wno-unknown-warning-option)
  else()
    target_compile_options(${target} PRIVATE -Wshadow)
  endif()
  # Results are the same, bit by bit, on processors that fuse multiplications and additions (ARM, x86-64-v3) and on those
  # that do not: a sum that differs in its last bit may turn a tie, and with it a whole hierarchy of places.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-stringop-overflow)
    # false positives inside std::string and fmt (GCC bug 105651)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # In a unity build GCC takes a .cpp for a header, where members of unnamed namespaces would be a mistake.
    target_compile_options(${target} PRIVATE $<${unity}:-Wno-subobject-linkage>)
  endif()
  if(ESTANCIA_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if("LIGHT" IN_LIST ARGN OR ESTANCIA_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  else()
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O3>)
  endif()
  if(NOT ESTANCIA_SANITIZE) # which look for the same, and better, but cannot be built with some of it
    # A fault in memory ends the program rather than obeying whoever wrote the file (OpenSSF Compiler Options Hardening
    # Guide). What is checked follows from the sizes that an optimizing compiler knows.
    target_compile_options(${target} PRIVATE -fstack-protector-strong -fstack-clash-protection
                                             $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=3>)
    if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
      target_compile_options(${target} PRIVATE -fcf-protection=full)
    elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
      target_compile_options(${target} PRIVATE -mbranch-protection=standard)
    endif()
    target_link_options(${target} PRIVATE -Wl,-z,relro,-z,now)
  endif()
  if(ESTANCIA_SANITIZE)
    # Function multiversioning resolves before the sanitizers start, so it is off here (core/simd.hpp).
    target_compile_definitions(${target} PRIVATE ESTANCIA_NO_MULTIVERSION)
    # Instrumented code makes GCC see uninitialized variables and overflows in <regex> and the like that are not.
    target_compile_options(${target} PRIVATE -fsanitize=${ESTANCIA_SANITIZE} -fno-sanitize-recover=undefined
                                             -fno-omit-frame-pointer -g1 -Wno-maybe-uninitialized -Wno-array-bounds)
    target_link_options(${target} PUBLIC -fsanitize=${ESTANCIA_SANITIZE})
    get_target_property(type ${target} TYPE)
    if(ESTANCIA_SANITIZE MATCHES "thread" AND type STREQUAL "EXECUTABLE")
      target_sources(${target} PRIVATE ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../tests/sanitizers/opencv_on_one_thread.cpp)
      target_link_libraries(${target} PRIVATE opencv_core)
    endif()
  endif()
  if(ESTANCIA_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
endfunction()
