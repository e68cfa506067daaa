// Temporal segments: splits a sequence into contiguous runs that cross-validation must not separate.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/frame.hpp"

namespace estancia {

/// Frames `first` … `first + size − 1` of a sequence.
struct TemporalSegment {
  std::size_t first = 0, size = 0;
  bool operator==(const TemporalSegment&) const = default;
};

/// The segments of a sequence, in order; together they are all frames. A new segment begins where the place
/// changes (`places`: one a frame, a room or finer), and within a place
/// * if all frames have time stamps: where the time from frame to frame is more than twice the median step;
/// * else if all names without extension are the same text followed by a whole number ("0012.png",
///   "frame000123.jpg"): where that number grows by more than its median step;
/// and in either case where it falls. Medians are of the positive steps within places. Other names are
/// ignored: the digits of "1305031102.175304.png" or "x-1.25_a0.71.png" are fractions.
/// Throws Error (mismatch) when there are not as many places as frames.
std::vector<TemporalSegment> temporalSegments(const std::vector<Frame>& frames,
                                              const std::vector<std::string>& places);

}  // namespace estancia
