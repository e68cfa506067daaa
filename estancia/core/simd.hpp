// SIMD multiversioning: hot loops are compiled once per instruction set; the processor chooses at start.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(ESTANCIA_NO_MULTIVERSION)
#define ESTANCIA_MULTIVERSION __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define ESTANCIA_TARGET_16_LANES __attribute__((target("avx512f")))
#define ESTANCIA_TARGET_8_LANES __attribute__((target("avx2,fma")))
#define ESTANCIA_HAS_TARGETS 1
#else
#define ESTANCIA_MULTIVERSION
#define ESTANCIA_TARGET_16_LANES
#define ESTANCIA_TARGET_8_LANES
#define ESTANCIA_HAS_TARGETS 0
#endif

namespace estancia {

/// A register of float32. A loop over vectors wider than the processor's keeps them in memory (GCC 12), so
/// such loops are compiled for each width and chosen by ofThisProcessor().
template <std::size_t lanes>
struct Simd {
  using Float [[gnu::vector_size(lanes * sizeof(float))]] = float;
  using Bits [[gnu::vector_size(lanes * sizeof(int))]] = int;
};

/// The version of a function for registers of 16 (AVX-512), 8 (AVX2 with FMA) or 4 float32 numbers, as this
/// processor has them; on ARM those of 4, which are NEON's.
template <class Function>
Function ofThisProcessor([[maybe_unused]] Function with16, [[maybe_unused]] Function with8, Function with4) {
#if ESTANCIA_HAS_TARGETS
  if (__builtin_cpu_supports("avx512f") != 0) return with16;
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) return with8;
#endif
  return with4;
}

}  // namespace estancia
