// Floor plan rendering: areas, walls, the driven path, and the heat of a word, seen from above.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <span>

#include "estancia/areas/areas.hpp"

namespace estancia::report {

/// The areas tinted and named, walls dark, the path dotted; the floor's first axis to the right, the second
/// up. Where `heat` is given, cells glow by it instead. BGR, 8 bits, about `width` pixels wide.
cv::Mat drawFloorPlan(const Areas& areas, const FloorHeat* heat = nullptr, int width = 1000);

}  // namespace estancia::report
