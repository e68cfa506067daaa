// Neuron of a Growing Neural Gas: its position and number of wins.
#pragma once

#include <cstdint>

#include "estancia/cloud/signals.hpp"

namespace estancia {

/// Half a cache line: what every signal reads of a neuron and of its neighbors. The search grid lists a
/// neuron at its home, from which it must not move too far.
struct alignas(32) Neuron {
  float x = 0, y = 0, z = 0;
  std::uint32_t wins = 0;  ///< modulo 2^32
  float homeX = 0, homeY = 0, homeZ = 0, zero = 0;

  Point4 at() const { return {x, y, z, 0}; }
};

}  // namespace estancia
