// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "findings/pivot.hpp"
#include "words/rooms_by_name.hpp"

namespace estancia::experiments {
namespace {

const std::string allRoomsRow = "(all)";

using NamedCells = std::vector<std::pair<std::string, CellResults>>;

/// Where any of the cells has the measure, in order.
std::vector<std::string> pointsOf(const NamedCells& rows, const std::string& measure) {
  std::vector<std::string> points;
  for (const auto& [name, cell] : rows)
    for (const CellResult& result : cell)
      if (result.measure == measure && result.at != allRoomsRow &&
          std::ranges::find(points, result.at) == points.end())
        points.push_back(result.at);
  return points;
}

ResultTable accuraciesOf(const std::string& task, const NamedCells& rows) {
  constexpr auto largest = ResultTable::Best::largest;
  std::vector<Measure<CellResults>> measures;
  for (const auto& [measure, column] : std::vector<std::pair<std::string, ResultTable::Column>>{
           {"images", {"images", 0}},
           {"chance", {"chance", 3}},
           {"accuracy", {"accuracy", 3, largest}},
           {"accuracy_low", {"from", 3}},
           {"accuracy_high", {"to", 3}},
           {"groups", {"groups", 0}},
           {"pooled_accuracy", {"pooled accuracy", 3, largest}},
           {"pooled_low", {"from", 3}},
           {"pooled_high", {"to", 3}},
           {"sure", {"sure", 3}},
           {"sure_accuracy", {"right of the sure", 3}}})
    measures.push_back(
        {column, [name = measure](const CellResults& cell) { return valueOf(cell, name, allRoomsRow); }});
  return pivot(ResultTable{task,
                           "Images by themselves, and pooled over groups of images of one room. Chance: the "
                           "share of the most frequent room. From, to: intervals of 95 %. Sure: the share of "
                           "groups that get a name.",
                           "data",
                           {},
                           {}},
               rows, measures);
}

ResultTable accuraciesByRoom(const std::string& task, const NamedCells& rows) {
  std::vector<Measure<CellResults>> measures;
  for (const std::string& room : pointsOf(rows, "accuracy"))
    measures.push_back(
        {{room, 3}, [room](const CellResults& cell) { return valueOf(cell, "accuracy", room); }});
  return pivot(
      ResultTable{task + ": by room", "Accuracy of the images of each room, by themselves.", "data", {}, {}},
      rows, measures);
}

ResultTable areasOfCell(const std::string& title, const CellResults& cell) {
  const std::vector<std::string> areas = pointsOf({{"", cell}}, "probability");
  return pivot({title + ": areas",
                "Each area, the room that it is in, and its name.",
                "area",
                {{"images", 0}, {"probability", 2}},
                {}},
               areas, [&](std::size_t r, std::size_t c) {
                 return valueOf(cell, c == 0 ? "images" : "probability", areas[r]);
               });
}

}  // namespace

Findings roomsByNameFindings(const DriveResults& results) {
  Findings findings;
  findings.title = "Rooms without an example";
  for (std::size_t t = 0; t < results.variants.size(); ++t) {
    NamedCells rows;
    results.each([&](std::size_t model, std::size_t drive) {
      rows.emplace_back(results.titleOf(model, drive), results.of(model, drive, t));
    });
    findings.sections.emplace_back(accuraciesOf(results.variants[t], rows));
    findings.sections.emplace_back(accuraciesByRoom(results.variants[t], rows));
    for (const auto& [name, cell] : rows)
      if (!pointsOf({{"", cell}}, "probability").empty())
        findings.sections.emplace_back(areasOfCell(fmt::format("{}, {}", results.variants[t], name), cell));
  }
  std::string shares;
  for (std::size_t d = 0; d < results.drives.size(); ++d) {
    const auto best = [&](const char* measure) {
      double most = 0;
      for (std::size_t m = 0; m < results.models.size(); ++m)
        most = std::max(most, valueOf(results.of(m, d), measure, allRoomsRow).value_or(0));
      return 100 * most;
    };
    shares += fmt::format("{}{:.1f} % of the images and {:.1f} % of the groups of {}", d == 0 ? "" : ", ",
                          best("accuracy"), best("pooled_accuracy"), results.drives[d]);
  }
  findings.summary =
      fmt::format("By the names of rooms alone, up to {} are named right ({}).", shares, results.variants[0]);
  return findings;
}

}  // namespace estancia::experiments
