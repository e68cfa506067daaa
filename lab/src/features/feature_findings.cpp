// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>

#include "features/feature_study.hpp"
#include "findings/pivot.hpp"
#include "runner/drive_grid.hpp"

namespace estancia::experiments {
namespace {

constexpr auto largest = ResultTable::Best::largest;

/// Each descriptor's distance: the one with the largest V-measure on the first drive, of equal ones the
/// first.
std::vector<std::size_t> chosenDistances(const FeatureResults& results) {
  std::vector<std::size_t> chosen;
  for (const auto& tasks : results.cells) {
    const auto valueAt = [&](std::size_t d) { return valueOf(tasks[0][d], "v_measure").value_or(0); };
    std::size_t best = 0;
    for (std::size_t d = 1; d < results.distances.size(); ++d)
      if (valueAt(d) > valueAt(best)) best = d;
    chosen.push_back(best);
  }
  return chosen;
}

std::string nameWith(const FeatureResults& results, std::size_t descriptor, std::size_t distance) {
  const std::string& name = results.descriptors[descriptor];
  return results.distances.size() == 1 ? name : fmt::format("{} ({})", name, results.distances[distance]);
}

/// All measures of the maps of one drive, a row a descriptor; of a single one, a row a distance.
ResultTable mapsOf(const FeatureResults& results, std::size_t task, const std::vector<std::size_t>& chosen) {
  std::vector<std::pair<std::string, CellResults>> rows;
  std::string caption =
      "The map against the rooms, the driven path and the positions; another drive found in it: the share of "
      "right answers by each image alone, by all images so far, and with twenty more.";
  const bool byDistance = results.descriptors.size() == 1 && results.distances.size() > 1;
  if (byDistance) {
    for (std::size_t d = 0; d < results.distances.size(); ++d)
      rows.emplace_back(results.distances[d], results.cells[0][task][d]);
  } else {
    for (std::size_t d = 0; d < results.descriptors.size(); ++d)
      rows.emplace_back(nameWith(results, d, chosen[d]), results.cells[d][task][chosen[d]]);
    if (results.distances.size() > 1)
      caption += task == 0 ? " Each descriptor has the distance of its best map of this drive."
                           : fmt::format(" Distances were chosen on {}.", results.tasks[0].name);
  }
  for (const auto& [name, found] : results.recognizers) rows.emplace_back(name, found[task]);
  if (valueOf(results.cells[0][task][0], "orders_v_measure"))
    caption += " The mean of orders is that of maps of the stays in rooms in random orders.";
  if (!results.recognizers.empty()) caption += " Taken for new: images of no place of the map, by FAB-MAP.";
  std::vector<CellResults> cells;
  for (const auto& row : rows) cells.push_back(row.second);
  return pivot(
      ResultTable{
          results.tasks[task].name, std::move(caption), byDistance ? "distance" : "descriptor", {}, {}},
      rows, measuresIn(cells, featureMeasures()));
}

/// One measure of the maps of one drive, a column a distance.
ResultTable byDistance(const FeatureResults& results, std::size_t task, const std::string& measure,
                       const std::string& title) {
  ResultTable head{
      fmt::format("{}: {} by distance", results.tasks[task].name, title), "", "descriptor", {}, {}};
  head.columns = columnsOf(results.distances, 3, largest);
  return pivot(std::move(head), results.descriptors, [&](std::size_t descriptor, std::size_t distance) {
    return valueOf(results.cells[descriptor][task][distance], measure);
  });
}

/// What classifiers learn of rooms, a column a set of them; no columns where there are none.
ResultTable roomsOf(const FeatureResults& results) {
  ResultTable head{"Rooms",
                   "Share of images whose room a support vector machine tells that has learned others.",
                   "descriptor",
                   {},
                   {}};
  std::vector<std::size_t> sets;
  for (std::size_t t = 0; t < results.tasks.size(); ++t)
    if (!results.tasks[t].isDrive) {
      sets.push_back(t);
      head.columns.push_back({results.tasks[t].name, 3, largest});
    }
  return pivot(std::move(head), results.descriptors, [&](std::size_t descriptor, std::size_t set) {
    return valueOf(results.cells[descriptor][sets[set]][0], "accuracy");
  });
}

}  // namespace

std::vector<std::pair<std::string, ResultTable::Column>> featureMeasures() {
  return {{"nodes", {"nodes", 0}},
          {"v_measure", {"V-measure", 3, largest}},
          {"orders_v_measure", {"V-measure, mean of orders", 3, largest}},
          {"seen_v_measure", {"V-measure, rooms seen", 3, largest}},
          {"ari", {"ARI", 3, largest}},
          {"purity", {"purity", 3, largest}},
          {"edge_precision", {"edge precision", 3, largest}},
          {"edge_recall", {"edge recall", 3, largest}},
          {"original", {"original score", 1, largest}},
          {"one_image", {"one image", 3, largest}},
          {"filtered", {"filtered", 3, largest}},
          {"smoothed", {"smoothed", 3, largest}},
          {"unknown", {"taken for new", 3}}};
}

Findings featureFindings(const FeatureResults& results) {
  Findings findings;
  findings.title = "Words, inner layers and image features";
  const auto chosen = chosenDistances(results);
  std::size_t drives = 0;
  for (std::size_t t = 0; t < results.tasks.size(); ++t)
    if (results.tasks[t].isDrive) {
      findings.sections.emplace_back(mapsOf(results, t, chosen));
      ++drives;
    }
  if (drives < results.tasks.size()) findings.sections.emplace_back(roomsOf(results));
  if (results.distances.size() > 1 && results.descriptors.size() > 1)
    for (std::size_t t = 0; t < drives; ++t)
      for (const auto& [measure, title] : {std::pair{"v_measure", "V-measure"}, {"one_image", "one image"}})
        if (valueOf(results.cells[0][t][0], measure))  // a drive without rooms has no V-measure
          findings.sections.emplace_back(byDistance(results, t, measure, title));
  findings.summary = fmt::format(
      "{} descriptors on {} drives, by images alone, all with thresholds that the runs found themselves.",
      results.descriptors.size(), drives);
  return findings;
}

}  // namespace estancia::experiments
