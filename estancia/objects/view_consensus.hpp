// View consensus: which segments of different frames show one thing. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "estancia/objects/instance_map.hpp"

namespace estancia {

/// Groups of masks, each ascending and in the order of their first mask; under-segmented masks and those of
/// walls are in none. `consensus`: the share of the frames that see two groups and have them in one mask,
/// from which on they are one. Pairs that many frames see are merged first (Yan et al. 2024, sections 3.2 and
/// 3.3).
std::vector<std::vector<std::uint32_t>> clusterMasks(const InstanceMap::Voxels& voxels,
                                                     const std::vector<InstanceMap::Mask>& masks,
                                                     double consensus);

}  // namespace estancia
