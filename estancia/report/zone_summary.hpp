// Zone summary: what a page shows of each zone, gathered once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/figures/color.hpp"
#include "estancia/figures/html.hpp"
#include "estancia/figures/visits.hpp"
#include "estancia/zones/zones.hpp"

namespace estancia::report {

struct ZoneSummary {
  const Zone* zone = nullptr;  ///< zone of the summarized zones
  ClassStyle style;
  double share = 0;               ///< share of all images, 0 … 1
  std::string name;               ///< its most distinctive labels, short enough for a page
  std::string word;               ///< the first of them
  std::vector<VisitSpan> visits;  ///< ascending, uninterrupted stays
};

struct ZonesSummary {
  const Zones* zones = nullptr;
  std::vector<ZoneSummary> list;  ///< in the order of Zones::zones: the largest first, position = id
  std::size_t styled = 0;         ///< the first so many have a style of their own, all others share one

  /// "Zone 3, corridor: 120 images, 12.5 %"
  std::string describe(std::size_t zone) const;

  /// How many images are in zones without a style of their own.
  std::size_t imagesUnstyled() const;

  /// Opens what a drawing shows of a zone: a link to `#zone-<id>` that carries the id as data-zone, or, for
  /// the zones without a style of their own (`zone` ≥ styled), a group.
  void openMark(Markup& svg, std::size_t zone, const std::string& kind) const;
};

/// `zones` must outlive the summary.
ZonesSummary summarize(const Zones& zones);

}  // namespace estancia::report
