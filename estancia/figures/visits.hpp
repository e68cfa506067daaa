// When the robot was somewhere: uninterrupted stays over the run.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/figures/html.hpp"

namespace estancia::report {

struct VisitSpan {
  std::size_t first = 0, last = 0;  ///< frame numbers, both included
};

/// Adds a frame later than all before: to the stay that it continues, else as a new one.
void addFrame(std::vector<VisitSpan>& visits, std::size_t frame);

/// The visits as a strip over a run of `frames`.
Markup visitStrip(const std::vector<VisitSpan>& visits, std::size_t frames);

/// "3 visits, frames 4 to 80"
std::string describeVisits(const std::vector<VisitSpan>& visits);

}  // namespace estancia::report
