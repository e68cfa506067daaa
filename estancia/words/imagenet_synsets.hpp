// ImageNet synsets: the thousand classes of ILSVRC 2012 as WordNet numbers, in their order.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace estancia {

/// Byte offsets of nouns in WordNet 3.0, rising: 1440764 is tench, n01440764 (Russakovsky et al. 2015:
/// ImageNet Large Scale Visual Recognition Challenge, Int. J. of Computer Vision 115).
extern const std::array<std::uint32_t, 1000> imageNetSynsets;

}  // namespace estancia
