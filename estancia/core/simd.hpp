// One binary that is quick on any x86-64: hot loops are compiled once per instruction set and chosen at
// start.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(ESTANCIA_NO_MULTIVERSION)
#define ESTANCIA_MULTIVERSION __attribute__((target_clones("arch=icelake-server", "arch=haswell", "default")))
#else
#define ESTANCIA_MULTIVERSION
#endif
