#include "experiments/src/recognition/thesis_means_checked.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/src/recognition/thesis_recognition.hpp"

namespace estancia::experiments {

ResultTable thesisMeansChecked() {
  constexpr double pairs = 49;
  ResultTable table{"The thesis' means against its own cells",
                    "Largest differences of a printed mean and the mean of the cells it is of, as printed "
                    "(whole percent) and as "
                    "the shares of 49 pairs that the cells then stand for. Cells that are no share of 49 "
                    "were measured on other "
                    "numbers of pairs, which the thesis does not tell.",
                    "means",
                    {{"means", 0},
                     {"cells", 0},
                     {"no share of 49", 0},
                     {"largest difference", 2},
                     {"with shares of 49", 2}},
                    {}};
  const auto cellsOf = [](const std::string& descriptor, const std::string& keypoint) {
    std::vector<const ThesisCells*> tables;
    for (const ThesisCells& cells : thesisCells())
      if (cells.descriptor == descriptor && (keypoint.empty() || cells.keypoint == keypoint))
        tables.push_back(&cells);
    return tables;
  };
  const auto share = [&](int percent) { return std::round(percent * pairs / 100) * 100 / pairs; };
  // Of a printed mean, and the places of its cells in the tables; one row a table, or a line of Table 2.17.
  struct Check {
    std::size_t means = 0, cells = 0, odd = 0;
    double printed = 0, exact = 0;
  };
  const auto check = [&](Check& row, const std::vector<const ThesisCells*>& tables, double mean,
                         const std::vector<std::size_t>& places) {
    double sum = 0, shares = 0;
    for (const ThesisCells* cells : tables)
      for (const std::size_t place : places) {
        const int percent = cells->percent[place];
        sum += percent;
        shares += share(percent);
        ++row.cells;
        row.odd += std::lround(share(percent)) != percent;
      }
    const auto count = static_cast<double>(tables.size() * places.size());
    ++row.means;
    row.printed = std::max(row.printed, std::abs(mean - sum / count));
    row.exact = std::max(row.exact, std::abs(mean - shares / count));
  };
  const auto add = [&](const std::string& name, const Check& row) {
    table.rows.push_back({name,
                          {static_cast<double>(row.means), static_cast<double>(row.cells),
                           static_cast<double>(row.odd), row.printed, row.exact}});
  };
  constexpr std::size_t columns = 9, noises = 6;
  for (const ThesisMeans& means : thesisMeans()) {
    const auto tables = cellsOf(means.descriptor, "");
    Check byNoise, bySize;
    for (std::size_t i = 0; i < means.percent.size(); ++i) check(byNoise, tables, means.percent[i], {i});
    for (std::size_t i = 0; i < means.percentOfSizes.size(); ++i) {
      std::vector<std::size_t> places;
      for (std::size_t n = 0; n < noises; ++n)
        places.push_back((i / columns * noises + n) * columns + i % columns);
      check(bySize, tables, means.percentOfSizes[i], places);
    }
    add(fmt::format("{} ({})", means.table, means.descriptor), byNoise);
    add(fmt::format("{} ({})", means.tableOfSizes, means.descriptor), bySize);
  }
  for (const ThesisOverall& overall : thesisOverall()) {
    const auto tables = cellsOf(overall.descriptor, overall.keypoint);
    Check row;
    const std::size_t bounds[] = {0, 1, 5, columns};  // the columns of the three filters
    for (std::size_t f = 0; f < overall.percent.size(); ++f) {
      std::vector<std::size_t> places;
      for (std::size_t i = 0; i < 18; ++i)
        for (std::size_t c = bounds[f]; c < bounds[f + 1]; ++c) places.push_back(i * columns + c);
      check(row, tables, overall.percent[f], places);
    }
    add(fmt::format("Table 2.17 ({}, {})", overall.descriptor, overall.keypoint), row);
  }
  return table;
}

}  // namespace estancia::experiments
