#include "estancia/experiment/recognition_findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "estancia/experiment/thesis_recognition.hpp"

namespace estancia {
namespace {

using Percent = double (RecognitionCell::*)() const;
using Values = std::vector<std::optional<double>>;

struct Score {
  const char* name;
  Percent percent;
};
constexpr Score kVerified{"verified", &RecognitionCell::verifiedPercent},
    kCorrect{"correct", &RecognitionCell::correctPercent},
    kFalse{"false positives", &RecognitionCell::falsePercent};

constexpr std::size_t mostOverviewRows = 60;

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::string millimetres(double metres) {
  return fmt::format("{:.4g} mm", 1000 * metres);
}

/// Tables and charts out of the results.
class Tables {
 public:
  explicit Tables(const RecognitionResults& results) : r_(results) {}

  void addAll(Findings& findings) const {
    addOverviews(findings);
    for (std::size_t p = 0; p < r_.presets.size(); ++p) addOverall(p, findings);
    addCurves(findings);
    for (std::size_t d = 0; d < r_.descriptors.size(); ++d) {
      for (std::size_t k = 0; k < r_.keypoints.size(); ++k) {
        for (std::size_t p = 0; p < r_.presets.size(); ++p)
          for (const Score& score : {kVerified, kCorrect, kFalse})
            findings.sections.emplace_back(cells(p, {k}, d, score));
        if (auto table = thesisTable(k, d)) findings.sections.emplace_back(std::move(*table));
      }
      addMeans(d, findings);
    }
    if (asksForThesis()) findings.sections.emplace_back(thesisMeansChecked());
  }

  std::string sentence() const {
    std::string text;
    for (const std::size_t n : {quietest(), noisiest()}) {
      if (!text.empty() && quietest() == noisiest()) break;
      const auto [cell, name] = best(n);
      text +=
          fmt::format("{}{}: at best {} of {} are found where they are, with {} of {} false positives ({}).",
                      text.empty() ? "" : " ",
                      r_.noises[n] == 0 ? "Without noise" : "With noise of " + millimetres(r_.noises[n]),
                      cell->correct, cell->pairs, cell->falsePositives, cell->absent, name);
    }
    return text;
  }

 private:
  const RecognitionCell& cell(std::size_t p, std::size_t k, std::size_t d, std::size_t m, std::size_t n,
                              std::size_t f) const {
    return r_.cells[r_.indexOf(p, k, d, m, n, f)];
  }

  std::size_t quietest() const {
    return static_cast<std::size_t>(std::min_element(r_.noises.begin(), r_.noises.end()) - r_.noises.begin());
  }
  std::size_t noisiest() const {
    return static_cast<std::size_t>(std::max_element(r_.noises.begin(), r_.noises.end()) - r_.noises.begin());
  }

  /// Calls use(p, k, d, m, f) for everything that was compared at each noise.
  template <class Use>
  void each(const Use& use) const {
    for (std::size_t p = 0; p < r_.presets.size(); ++p)
      for (std::size_t k = 0; k < r_.keypoints.size(); ++k)
        for (std::size_t d = 0; d < r_.descriptors.size(); ++d)
          for (std::size_t m = 0; m < r_.modelFilters.size(); ++m)
            for (std::size_t f = 0; f < r_.sceneFilters.size(); ++f) use(p, k, d, m, f);
  }

  /// What is not the same for all.
  std::string nameOf(std::size_t p, std::size_t k, std::size_t d, std::size_t m, std::size_t f) const {
    std::vector<std::string> parts;
    if (r_.presets.size() > 1) parts.push_back(r_.presets[p]);
    if (r_.descriptors.size() > 1) parts.push_back(r_.descriptors[d]);
    if (r_.keypoints.size() > 1) parts.push_back(r_.keypoints[k]);
    if (r_.modelFilters.size() > 1) parts.push_back(fmt::format("{} models", r_.modelFilters[m]));
    if (r_.sceneFilters.size() > 1 || parts.empty()) parts.push_back(estancia::nameOf(r_.sceneFilters[f]));
    return fmt::format("{}", fmt::join(parts, ", "));
  }

  /// The most correct at a noise; of equals the one with the fewest false positives, then the first.
  std::pair<const RecognitionCell*, std::string> best(std::size_t n) const {
    const RecognitionCell* most = nullptr;
    std::string name;
    each([&](auto p, auto k, auto d, auto m, auto f) {
      const RecognitionCell& here = cell(p, k, d, m, n, f);
      if (most != nullptr && (here.correct < most->correct ||
                              (here.correct == most->correct && here.falsePositives >= most->falsePositives)))
        return;
      most = &here;
      name = nameOf(p, k, d, m, f);
    });
    return {most, name};
  }

  /// Everything in rows, the noise in columns, where that is not too much.
  void addOverviews(Findings& findings) const {
    std::size_t rows = 0;
    each([&](auto...) { ++rows; });
    if (rows < 2 || rows > mostOverviewRows) return;
    for (const Score& score : {kCorrect, kFalse, kVerified}) {
      ResultTable table{fmt::format("Percent {}, by noise", score.name), "", "scenes", {}, {}, 100};
      for (const double noise : r_.noises) table.columns.push_back({millimetres(noise), 1});
      each([&](auto p, auto k, auto d, auto m, auto f) {
        Values values;
        for (std::size_t n = 0; n < r_.noises.size(); ++n)
          values.push_back((cell(p, k, d, m, n, f).*score.percent)());
        table.rows.push_back({nameOf(p, k, d, m, f), std::move(values)});
      });
      findings.sections.emplace_back(std::move(table));
    }
    ResultTable seconds{
        "Seconds a pair, by noise",
        "On one thread; the scene's filter and description are paid by every pair, models are ready.",
        "scenes",
        {},
        {}};
    for (const double noise : r_.noises) seconds.columns.push_back({millimetres(noise), 2});
    each([&](auto p, auto k, auto d, auto m, auto f) {
      Values values;
      for (std::size_t n = 0; n < r_.noises.size(); ++n) values.push_back(cell(p, k, d, m, n, f).seconds);
      seconds.rows.push_back({nameOf(p, k, d, m, f), std::move(values)});
    });
    findings.sections.emplace_back(std::move(seconds));
  }

  std::string titleOf(std::size_t p, std::size_t d, const std::string& rest) const {
    return fmt::format("{}{}, {}", r_.presets.size() > 1 ? r_.presets[p] + ": " : "", r_.descriptors[d],
                       rest);
  }

  ResultTable empty(const std::string& title, const std::string& rowsAre) const {
    ResultTable table{title, "", rowsAre, {}, {}, 100};
    for (const auto& filter : r_.sceneFilters) table.columns.push_back({estancia::nameOf(filter), 0});
    return table;
  }

  /// The thesis' layout; the mean over `keypoints`.
  ResultTable cells(std::size_t p, const std::vector<std::size_t>& keypoints, std::size_t d,
                    const Score& score) const {
    ResultTable table = empty(titleOf(p, d,
                                      fmt::format("{}: percent {}",
                                                  keypoints.size() > 1 ? "mean of the keypoint detectors"
                                                                       : r_.keypoints[keypoints[0]],
                                                  score.name)),
                              "models, noise");
    for (std::size_t m = 0; m < r_.modelFilters.size(); ++m)
      for (std::size_t n = 0; n < r_.noises.size(); ++n) {
        Values values;
        for (std::size_t f = 0; f < r_.sceneFilters.size(); ++f) {
          std::vector<double> all;
          for (const std::size_t k : keypoints) all.push_back((cell(p, k, d, m, n, f).*score.percent)());
          values.push_back(mean(all));
        }
        table.rows.push_back({fmt::format("{}, {}", r_.modelFilters[m], millimetres(r_.noises[n])), values});
      }
    return table;
  }

  /// The same, and the mean over the noise.
  ResultTable sizes(std::size_t p, std::size_t d, const Score& score) const {
    ResultTable table =
        empty(titleOf(p, d, fmt::format("mean of the keypoint detectors and noises: percent {}", score.name)),
              "models");
    for (std::size_t m = 0; m < r_.modelFilters.size(); ++m) {
      Values values;
      for (std::size_t f = 0; f < r_.sceneFilters.size(); ++f) {
        std::vector<double> all;
        for (std::size_t k = 0; k < r_.keypoints.size(); ++k)
          for (std::size_t n = 0; n < r_.noises.size(); ++n)
            all.push_back((cell(p, k, d, m, n, f).*score.percent)());
        values.push_back(mean(all));
      }
      table.rows.push_back({r_.modelFilters[m], std::move(values)});
    }
    return table;
  }

  void addMeans(std::size_t d, Findings& findings) const {
    if (r_.keypoints.size() < 2) return;
    std::vector<std::size_t> all(r_.keypoints.size());
    std::iota(all.begin(), all.end(), 0U);
    for (std::size_t p = 0; p < r_.presets.size(); ++p)
      for (const Score& score : {kVerified, kCorrect, kFalse}) {
        findings.sections.emplace_back(cells(p, all, d, score));
        findings.sections.emplace_back(sizes(p, d, score));
      }
    for (const ThesisMeans& means : thesisMeans()) {
      if (means.descriptor != r_.descriptors[d]) continue;
      findings.sections.emplace_back(thesisLayout(
          fmt::format("The thesis' {}: {}, mean of the keypoint detectors", means.table, means.descriptor),
          {means.percent.begin(), means.percent.end()}));
      findings.sections.emplace_back(
          thesisLayout(fmt::format("The thesis' {}: the same, mean of the noises", means.tableOfSizes),
                       {means.percentOfSizes.begin(), means.percentOfSizes.end()}));
    }
  }

  bool asksForThesis() const {
    for (std::size_t d = 0; d < r_.descriptors.size(); ++d)
      for (std::size_t k = 0; k < r_.keypoints.size(); ++k)
        if (thesisTable(k, d)) return true;
    return false;
  }

  /// Rows are model filters, by noise where there are as many.
  static ResultTable thesisLayout(const std::string& title, const std::vector<int>& percent) {
    ResultTable table{title, "Percent of the thesis' 49 pairs that were verified.", "models, noise", {}, {},
                      100};
    for (const auto& filter : thesisSceneFilters()) table.columns.push_back({estancia::nameOf(filter), 0});
    const std::size_t columns = table.columns.size(), rows = percent.size() / columns,
                      perModel = rows / thesisModelFilters().size();
    for (std::size_t row = 0; row < rows; ++row) {
      Values values;
      for (std::size_t c = 0; c < columns; ++c) values.emplace_back(percent[row * columns + c]);
      const std::string& model = thesisModelFilters()[row / perModel];
      table.rows.push_back(
          {perModel == 1 ? model : fmt::format("{}, {}", model, millimetres(thesisNoises()[row % perModel])),
           std::move(values)});
    }
    return table;
  }

  std::optional<ResultTable> thesisTable(std::size_t k, std::size_t d) const {
    for (const ThesisCells& table : thesisCells())
      if (table.descriptor == r_.descriptors[d] && table.keypoint == r_.keypoints[k])
        return thesisLayout(
            fmt::format("The thesis' {}: {}, {}", table.table, table.descriptor, table.keypoint),
            {table.percent.begin(), table.percent.end()});
    return std::nullopt;
  }

  /// Table 2.17 in both scores, beside the thesis'.
  void addOverall(std::size_t p, Findings& findings) const {
    std::vector<std::string> filters;
    for (const auto& [method, points] : r_.sceneFilters)
      if (std::find(filters.begin(), filters.end(), method) == filters.end()) filters.push_back(method);
    ResultTable table{
        fmt::format("{}By descriptor, detector and filter of the scenes (Table 2.17)",
                    r_.presets.size() > 1 ? r_.presets[p] + ": " : ""),
        fmt::format(
            "Mean percent over {} model filters, {} noise levels and the sizes. The thesis' is over three "
            "model filters, six noise levels up to 10 mm and four sizes, and counts what is verified.",
            r_.modelFilters.size(), r_.noises.size()),
        "descriptor, keypoints",
        {},
        {},
        100};
    for (const std::string& filter : filters)
      for (const char* what : {"thesis", kVerified.name, kCorrect.name, kFalse.name})
        table.columns.push_back({fmt::format("{}: {}", filter, what), 1});
    for (std::size_t d = 0; d < r_.descriptors.size(); ++d)
      for (std::size_t k = 0; k < r_.keypoints.size(); ++k) {
        Values values;
        for (const std::string& filter : filters) {
          values.push_back(thesisOverallOf(d, k, filter));
          for (const Score& score : {kVerified, kCorrect, kFalse}) {
            std::vector<double> all;
            for (std::size_t m = 0; m < r_.modelFilters.size(); ++m)
              for (std::size_t n = 0; n < r_.noises.size(); ++n)
                for (std::size_t f = 0; f < r_.sceneFilters.size(); ++f)
                  if (r_.sceneFilters[f].first == filter)
                    all.push_back((cell(p, k, d, m, n, f).*score.percent)());
            values.push_back(mean(all));
          }
        }
        table.rows.push_back({fmt::format("{}, {}", r_.descriptors[d], r_.keypoints[k]), std::move(values)});
      }
    findings.sections.emplace_back(std::move(table));
  }

  std::optional<double> thesisOverallOf(std::size_t d, std::size_t k, const std::string& filter) const {
    const std::vector<std::string> order{"none", "gng", "voxel"};
    const auto column =
        static_cast<std::size_t>(std::find(order.begin(), order.end(), filter) - order.begin());
    for (const ThesisOverall& row : thesisOverall())
      if (row.descriptor == r_.descriptors[d] && row.keypoint == r_.keypoints[k] &&
          column < row.percent.size())
        return row.percent[column];
    return std::nullopt;
  }

  /// Fig. 2.6–2.8, in the honest score.
  void addCurves(Findings& findings) const {
    if (r_.noises.size() < 2) return;
    std::vector<std::size_t> order(r_.noises.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return r_.noises[a] < r_.noises[b]; });
    for (std::size_t p = 0; p < r_.presets.size(); ++p)
      for (std::size_t d = 0; d < r_.descriptors.size(); ++d)
        for (std::size_t m = 0; m < r_.modelFilters.size(); ++m) {
          LineChart chart{titleOf(p, d, fmt::format("models {}: percent correct", r_.modelFilters[m])),
                          r_.keypoints.size() > 1 ? "The mean of the keypoint detectors." : "",
                          "noise [mm]",
                          "percent correct",
                          false,
                          {},
                          {},
                          true};
          for (const std::size_t n : order) chart.x.push_back(1000 * r_.noises[n]);
          for (std::size_t f = 0; f < r_.sceneFilters.size(); ++f) {
            LineChart::Line line{estancia::nameOf(r_.sceneFilters[f]), {}};
            for (const std::size_t n : order) {
              std::vector<double> all;
              for (std::size_t k = 0; k < r_.keypoints.size(); ++k)
                all.push_back(cell(p, k, d, m, n, f).correctPercent());
              line.y.push_back(mean(all));
            }
            chart.lines.push_back(std::move(line));
          }
          findings.sections.emplace_back(std::move(chart));
        }
  }

  const RecognitionResults& r_;
};

}  // namespace

std::string nameOf(const RecognitionResults::SceneFilter& filter) {
  return filter.second == 0 ? filter.first : fmt::format("{} {}", filter.first, filter.second);
}

std::vector<std::string> RecognitionCell::measures() {
  return {"pairs",         "verified", "correct", "false_positives", "seconds",       "filter_seconds",
          "model_seconds", "absent",   "failed",  "seeds",           "correct_least", "correct_most"};
}

CellResults RecognitionCell::toResults() const {
  const auto [least, most] = std::minmax_element(correctBySeed.begin(), correctBySeed.end());
  CellResults results{
      {"seconds", "", seconds}, {"filter_seconds", "", filterSeconds}, {"model_seconds", "", modelSeconds}};
  for (const auto& [measure, count] : {std::pair<const char*, std::size_t>{"pairs", pairs},
                                       {"verified", verified},
                                       {"correct", correct},
                                       {"false_positives", falsePositives},
                                       {"absent", absent},
                                       {"failed", failed},
                                       {"seeds", seeds},
                                       {"correct_least", least == correctBySeed.end() ? 0 : *least},
                                       {"correct_most", most == correctBySeed.end() ? 0 : *most}})
    results.push_back({measure, "", static_cast<double>(count)});
  return results;
}

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

Findings findingsOf(const RecognitionResults& results) {
  const Tables tables(results);
  Findings findings;
  findings.title = "Objects in noise";
  findings.summary = tables.sentence();
  tables.addAll(findings);
  std::size_t failed = 0, all = 0;
  for (const RecognitionCell& cell : results.cells) {
    failed += cell.failed;
    all += cell.pairs + cell.absent;
  }
  if (failed > 0)
    findings.notes.push_back(
        fmt::format("In {} of {} cases the scene or the model had nothing that could be described; they "
                    "count as not found.",
                    failed, all));
  return findings;
}

}  // namespace estancia
