// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/visits.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/figures/svg.hpp"

namespace estancia::report {

void addFrame(std::vector<VisitSpan>& visits, std::size_t frame) {
  if (visits.empty() || visits.back().last + 1 < frame)
    visits.push_back({frame, frame});
  else
    visits.back().last = frame;
}

Markup visitStrip(const std::vector<VisitSpan>& visits, std::size_t frames) {
  constexpr double width = 300;
  const auto whole = static_cast<double>(std::max<std::size_t>(frames, 1));
  Path path;
  double drawn = -1;
  for (const VisitSpan& visit : visits) {
    const double from = std::max(width * static_cast<double>(visit.first) / whole, drawn);
    const double to = std::max(width * static_cast<double>(visit.last + 1) / whole, from + 1);
    if (to <= drawn + 0.5) continue;  // less than can be seen
    path.move(from, 4).line(to, 4);
    drawn = to;
  }
  Markup strip;
  strip.open("svg", {{"class", "visits"},
                     {"viewBox", fmt::format("0 0 {} 8", width)},
                     {"preserveAspectRatio", "none"},
                     {"role", "img"},
                     {"aria-label", counted(visits.size(), "visit") + " over the run"}});
  if (!path.empty()) strip.leaf("path", {{"d", path.str()}});
  return strip.close();
}

std::string describeVisits(const std::vector<VisitSpan>& visits) {
  if (visits.empty()) return "never seen";
  if (visits.front().first == visits.back().last)
    return fmt::format("seen once, at frame {}", visits.front().first);
  return fmt::format("{}, frames {} to {}", counted(visits.size(), "visit"), visits.front().first,
                     visits.back().last);
}

}  // namespace estancia::report
