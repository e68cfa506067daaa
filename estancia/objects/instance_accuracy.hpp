// Instance accuracy: things that were found in a map against those that are there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/core/oriented_box.hpp"

namespace estancia {

/// A found and a true box that are the same thing, by their positions in the lists.
struct BoxMatch {
  std::size_t found = 0, thing = 0;
  double overlap = 0;
};

/// Matches boxes one to one, those of largest intersection over union first, as long as it is at least
/// `least`. In the order of matching.
std::vector<BoxMatch> matchBoxes(std::span<const OrientedBox> found, std::span<const OrientedBox> things,
                                 double least = 0.25);

}  // namespace estancia
