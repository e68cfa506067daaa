// SIMD multiversioning: hot loops are compiled once per instruction set; the processor chooses at start.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(ESTANCIA_NO_MULTIVERSION)
#define ESTANCIA_MULTIVERSION __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ESTANCIA_MULTIVERSION
#endif
