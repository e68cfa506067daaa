// Segment image: what each pixel of a view shows, CV_8U.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace estancia {

/// 0: no segment; 1 to maxSegments: the number of its segment.
constexpr std::uint8_t maxSegments = 253;
/// An upright plane that passes for a wall. In a view that does not show its edges, the front of a cabinet
/// looks the same.
constexpr std::uint8_t wallPixel = 254;
/// On no plane of the room and in no segment: leaves, thin legs, crumbs.
constexpr std::uint8_t loosePixel = 255;

/// Whether the pixel is in a segment.
constexpr bool inSegment(std::uint8_t pixel) {
  return pixel > 0 && pixel <= maxSegments;
}

}  // namespace estancia
