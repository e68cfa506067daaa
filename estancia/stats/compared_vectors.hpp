// Compared vectors: descriptors embedded, standardized and weighted for their comparison.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/label_scale.hpp"

namespace estancia {

/// Prepares one embedded descriptor for compare(): centered and weighted by `standardization` (unless that is
/// empty), its parts weighted, and of unit length for a cosine.
std::vector<float> comparedVector(const Distance& distance, const Standardization& standardization,
                                  std::span<const float> embedded);

/// Embeds descriptors, then prepares each as above. N×L.
DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const Distance& distance,
                                 const Standardization& standardization);

/// Prepares descriptors as a map compares them by `distance`, which has their parts: embedded, for a
/// standardized distance centered and scaled by the run `scale`, then as comparedVector(). N×L.
DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const DescriptorMatrix& scale,
                                 const Distance& distance);

/// Prepares descriptors as zones compare them: standardized, if at all, by all of them in any order. N×L.
DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const Distance& distance);

}  // namespace estancia
