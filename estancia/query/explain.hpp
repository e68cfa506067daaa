// Decision explanation: why a frame belongs to its node.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/map_file/map.hpp"

namespace estancia {

/// The frame with that name, else with that number. Throws Error (unknownName) when there is none.
std::size_t getFrame(const TopologicalMap& map, const std::string& nameOrNumber);

/// Sentences: what was decided for the frame, its distances against the thresholds, what other thresholds
/// would have led to, and how its node was merged later. Throws Error when the frame does not exist
/// (unknownName) or was not mapped (insufficientData).
std::vector<std::string> explain(const TopologicalMap& map, std::size_t frame);

/// Sentences: what was decided for a frame, by that name of it, and its distances against the thresholds.
std::vector<std::string> explain(const Decision& decision, const std::string& name);

}  // namespace estancia
