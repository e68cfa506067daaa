// Room classes: classes of images within the category of their room, for measures of zones.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"

namespace estancia::experiments {

/// Classes of images that follow each other: temporalSegments() of one room and one value of `marks` (one a
/// frame; empty: no marks). Each run is cut into `parts` equal parts, in order. "kitchen 1", "kitchen 2"
/// …, one a frame; "" where `rooms` is "".
std::vector<std::string> classesOfRuns(const std::vector<Frame>& frames,
                                       const std::vector<std::string>& rooms,
                                       const std::vector<std::string>& marks, std::size_t parts);

}  // namespace estancia::experiments
