// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/confusion_findings.hpp"

#include <fmt/format.h>

#include <limits>
#include <numeric>

#include "estancia/figures/text.hpp"
#include "estancia/stats/proportion.hpp"

namespace estancia {

std::size_t rightOf(const Confusion& confusion) {
  std::size_t right = 0;
  for (std::size_t r = 0; r < confusion.rooms.size(); ++r) right += confusion.counts[r][r];
  return right;
}

Findings findingsOf(const Confusion& confusion, const std::string& title,
                    std::vector<std::pair<std::string, std::string>> facts) {
  const std::size_t total = confusion.total(), right = rightOf(confusion);
  const auto [low, high] = wilsonInterval(right, total);
  Findings findings;
  findings.title = title;
  findings.summary = fmt::format(
      "{} of {} are taken for their true room: {:.1f} % (95 % interval {:.1f} … {:.1f} %, if images were "
      "independent), balanced {:.1f} %.",
      right, report::counted(total, "image"), 100 * confusion.accuracy(), 100 * low, 100 * high,
      100 * confusion.balancedAccuracy());
  findings.facts = std::move(facts);
  ResultTable table{"Rooms", "", "room", {{"images", 0}, {"right [%]", 1, ResultTable::Best::largest}}, {}};
  HeatTable matrix{"What is taken for what",
                   "Share of a true room's images (row) by what they are taken for (column) [%]",
                   confusion.rooms,
                   {},
                   0};
  for (std::size_t r = 0; r < confusion.rooms.size(); ++r) {
    const auto& row = confusion.counts[r];
    const auto all = static_cast<double>(std::accumulate(row.begin(), row.end(), std::size_t{0}));
    const auto share = [all](std::size_t count) { return 100 * static_cast<double>(count) / all; };
    table.rows.push_back({confusion.rooms[r], {all, all > 0 ? std::optional(share(row[r])) : std::nullopt}});
    for (const std::size_t count : row)
      matrix.values.push_back(all > 0 ? share(count) : std::numeric_limits<double>::quiet_NaN());
  }
  findings.sections = {std::move(table), std::move(matrix)};
  return findings;
}

}  // namespace estancia
