# SPDX-License-Identifier: Apache-2.0
# Compiles for 64-bit ARM (arm64: Raspberry Pi 3 to 5, Jetson) with Debian's cross compiler, against the libraries of
# a sysroot that script/sysroot makes; tests run under qemu-user. script/cross does it all.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})

if(DEFINED ENV{ESTANCIA_SYSROOT})
  set(CMAKE_SYSROOT $ENV{ESTANCIA_SYSROOT})
else()
  set(CMAKE_SYSROOT $ENV{HOME}/.cache/estancia/sysroot-arm64)
endif()
if(NOT EXISTS ${CMAKE_SYSROOT})
  message(FATAL_ERROR "there is no sysroot in ${CMAKE_SYSROOT}; run script/sysroot")
endif()
# Programs are this machine's, all else is the sysroot's.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${CMAKE_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${CMAKE_SYSROOT}/usr/lib/${triplet}/pkgconfig:${CMAKE_SYSROOT}/usr/share/pkgconfig)
# The linker looks for the libraries of libraries; those of BLAS lie where the system's alternatives would point to.
string(APPEND CMAKE_EXE_LINKER_FLAGS_INIT " -Wl,-rpath-link,${CMAKE_SYSROOT}/usr/lib/${triplet}")

find_program(QEMU NAMES qemu-aarch64 qemu-aarch64-static)
if(QEMU)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${QEMU} -L ${CMAKE_SYSROOT})
endif()
