// Cross-validation that does not fool itself: neighboring images stay together.
#pragma once

#include <cstdint>
#include <vector>

#include "estancia/core/frame.hpp"

namespace estancia {

/// One group a run of frames of one room (core/frame_runs.hpp). A room of fewer runs than `least` has its
/// longest ones cut, so that each room can be learned and held out; but into pieces of a few frames at least.
std::vector<int> runsOfRooms(const std::vector<Frame>& frames, int least);

/// One group an instance, a thing that several samples show. Where only one instance has a class as its most
/// frequent, that is cut into up to `pieces` of a few neighboring samples, so that the class can be learned
/// and held out. As many numbers as `classes` and `instances`.
std::vector<int> groupsOfInstances(const std::vector<int>& classes, const std::vector<int>& instances,
                                   int pieces);

/// The fold (0 … folds − 1) of each sample: groups whole, classes spread as evenly as they allow. Greedy, the
/// largest groups first; equal ones in an order that the seed shuffles.
std::vector<int> groupedFolds(const std::vector<int>& classes, const std::vector<int>& groups, int folds,
                              std::uint64_t seed);

}  // namespace estancia
