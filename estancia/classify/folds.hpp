// Grouped cross-validation: neighboring images stay in one fold.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "estancia/core/frame.hpp"

namespace estancia {

/// One group a temporal segment of one room (core/temporal_segments.hpp). The longest segments of a room with
/// fewer than `minSegments` are cut, so that each room can be learned and held out; but not into pieces of
/// less than a few frames.
std::vector<int> segmentGroups(const std::vector<Frame>& frames, int minSegments);

/// One group an object instance of several samples. A class with only one instance has it cut into up to
/// `pieces` of a few neighboring samples, so that the class can be learned and held out. `classes`,
/// `instances` and the result have the same length.
std::vector<int> instanceGroups(const std::vector<int>& classes, const std::vector<int>& instances,
                                int pieces);

/// The fold (0 … folds − 1) of each sample: groups whole, classes spread as evenly as possible. Greedy, the
/// largest groups first; equal ones in an order shuffled by the seed.
std::vector<int> groupedFolds(const std::vector<int>& classes, const std::vector<int>& groups, int folds,
                              std::uint64_t seed);

}  // namespace estancia
