// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/zone_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "estancia/figures/symbols.hpp"

namespace estancia::report {

RoomCounts countRooms(const Zones& zones, std::size_t columns) {
  const std::size_t wide = std::min(columns + 1, zones.zones.size());
  std::map<std::string, std::vector<std::size_t>> byRoom;
  for (std::size_t i = 0; i < zones.frames.size(); ++i) {
    if (zones.frames[i].room.empty()) continue;
    auto& row = byRoom.try_emplace(zones.frames[i].room, wide).first->second;
    ++row[std::min(static_cast<std::size_t>(zones.zoneOf[i]), wide - 1)];
  }
  std::vector<std::pair<std::string, std::vector<std::size_t>>> rows(byRoom.begin(), byRoom.end());
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
    const auto main = [](const auto& counts) {
      return std::max_element(counts.begin(), counts.end()) - counts.begin();
    };
    return main(a.second) < main(b.second);
  });
  RoomCounts result;
  for (auto& [room, counts] : rows) {
    result.rooms.push_back(room);
    result.counts.push_back(std::move(counts));
  }
  return result;
}

Markup roomTable(const ZonesSummary& summary, const RoomCounts& counts) {
  constexpr std::size_t maxRows = 200;
  Markup table;
  table.open("div", {{"class", "scroll"}, {"tabindex", "0"}}).open("table", {{"class", "numbers counts"}});
  table.open("thead").open("tr").element("th", {{"scope", "col"}}, "room");
  const std::size_t columns = counts.counts.empty() ? 0 : counts.counts.front().size();
  for (std::size_t zone = 0; zone < columns; ++zone) {
    table.open("th", {{"scope", "col"}});
    if (zone + 1 == columns && columns < summary.list.size()) {
      table.text("others").close();
      continue;
    }
    table.open("a", {{"href", fmt::format("#zone-{}", zone)}, {"title", summary.describe(zone)}});
    table.add(symbol(summary.list[zone].style)).text(std::to_string(zone)).close().close();
  }
  table.close().close().open("tbody");
  for (std::size_t row = 0; row < std::min(maxRows, counts.rooms.size()); ++row) {
    const auto& cells = counts.counts[row];
    const auto images = static_cast<double>(std::accumulate(cells.begin(), cells.end(), std::size_t{0}));
    table.open("tr").element("th", {{"scope", "row"}}, shorten(counts.rooms[row], 40));
    for (const std::size_t count : cells) {
      constexpr double dark = 0.88;  // from here on white reads better than black
      const double share = static_cast<double>(count) / images;
      if (count == 0)
        table.element("td", "");
      else
        table.element("td",
                      {{"class", share > dark ? "most" : "some"}, {"style", "--share:" + number(share)}},
                      grouped(count));
    }
    table.close();
  }
  table.close().close().close();
  if (counts.rooms.size() > maxRows)
    table.element("p", {{"class", "note"}},
                  fmt::format("{} more are not shown.", counted(counts.rooms.size() - maxRows, "room")));
  return table;
}

}  // namespace estancia::report
