// SPDX-License-Identifier: Apache-2.0
#include "places/model_choice_findings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/stats/rank_tests.hpp"
#include "findings/pivot.hpp"
#include "findings/thesis.hpp"

namespace estancia::experiments {
namespace {

constexpr const char* varianceName = "spatial_variance";          // mean over clusters
constexpr const char* byImageName = "spatial_variance_by_image";  // mean over images
constexpr const char* queriesName = "place_queries";
constexpr const char* rightName = "place_right";
constexpr const char* chanceName = "place_chance";
using Order = std::vector<std::size_t>;

/// k = 1 … this are in all cells.
std::size_t commonClusters(const ModelChoiceResults& results) {
  std::size_t k = results.cells.front().variance.size();
  for (const ModelChoiceCell& cell : results.cells) k = std::min(k, cell.variance.size());
  return k;
}

/// A test for every k: what each model reached on the sequence, as a share of the variance of all positions.
std::vector<std::vector<double>> testsOf(const ModelChoiceResults& results, std::size_t distance,
                                         std::size_t drive) {
  std::vector<std::vector<double>> tests(commonClusters(results));
  for (std::size_t k = 0; k < tests.size(); ++k)
    for (std::size_t m = 0; m < results.models.size(); ++m) {
      const auto& variance = results.cell(distance, drive, m).variance;
      tests[k].push_back(variance[k].overClusters / variance[0].overClusters);
    }
  return tests;
}

/// One sequence, or the mean over all of them.
struct Variances {
  std::vector<std::vector<double>> curves;  // [model][k − 1], in %
  std::vector<MethodStanding> standings;
  Order order;  // best model first
};

Variances compareBy(const std::vector<std::vector<std::vector<double>>>& testsOfDrives) {
  const std::size_t models = testsOfDrives.front().front().size();
  Variances result;
  result.curves.resize(models);
  std::vector<std::vector<double>> all;
  for (const auto& tests : testsOfDrives) all.insert(all.end(), tests.begin(), tests.end());
  for (std::size_t m = 0; m < models; ++m)
    for (std::size_t k = 0; k < testsOfDrives.front().size(); ++k) {
      double sum = 0;
      for (const auto& tests : testsOfDrives) sum += tests[k][m];
      result.curves[m].push_back(100 * sum / static_cast<double>(testsOfDrives.size()));
    }
  result.standings = standings(all, Better::smaller);
  result.order = ascending(models, [&](std::size_t m) { return result.standings[m].meanRank; });
  return result;
}

LineChart chartOf(const ModelChoiceResults& results, const Variances& variances, const std::string& title) {
  LineChart chart{title, "", "number of clusters k", "variance left [%], logarithmic", true, {}, {}};
  for (std::size_t k = 1; k <= variances.curves.front().size(); ++k)
    chart.x.push_back(static_cast<double>(k));
  for (std::size_t m = 0; m < results.models.size(); ++m)  // in one order, so in the same colors everywhere
    chart.lines.push_back({results.models[m], variances.curves[m]});
  return chart;
}

ResultTable tableOf(const ModelChoiceResults& results, const Variances& variances,
                    const std::vector<std::size_t>& shown, const std::string& title) {
  using Best = ResultTable::Best;
  std::vector<std::pair<std::string, std::size_t>> models;
  for (const std::size_t m : variances.order) models.emplace_back(results.models[m], m);
  std::vector<Measure<std::size_t>> measures;
  for (const std::size_t k : shown)
    if (k <= variances.curves.front().size())
      measures.push_back({{fmt::format("k = {} [%]", k), 1, Best::smallest},
                          [&variances, k](std::size_t m) { return variances.curves[m][k - 1]; }});
  measures.push_back(
      {{"mean rank", 2, Best::smallest}, [&](std::size_t m) { return variances.standings[m].meanRank; }});
  const auto addCount = [&](const char* name, Best best, std::size_t MethodStanding::*count) {
    measures.push_back({{name, 0, best}, [&variances, count](std::size_t m) {
                          return static_cast<double>(variances.standings[m].*count);
                        }});
  };
  addCount("wins", Best::largest, &MethodStanding::wins);
  addCount("ties", Best::none, &MethodStanding::ties);
  addCount("losses", Best::smallest, &MethodStanding::losses);
  return pivot<std::size_t>({title, "", "model", {}, {}}, models, measures);
}

StackedBars barsOf(const ModelChoiceResults& results, const Variances& variances) {
  StackedBars bars{"Wins, ties and losses",
                   "Each model against each other one, for every k and sequence.",
                   {"wins", "ties", "losses"},
                   {}};
  for (const std::size_t m : variances.order) {
    const MethodStanding& s = variances.standings[m];
    bars.bars.push_back(
        {results.models[m],
         {static_cast<double>(s.wins), static_cast<double>(s.ties), static_cast<double>(s.losses)}});
  }
  return bars;
}

/// Share of right places in %, absent where no place is seen twice.
std::optional<double> percentRight(const ModelChoiceCell& cell) {
  if (cell.recognition.queries == 0) return std::nullopt;
  return 100 * cell.recognition.right;
}

/// A column a sequence that has queries, and their mean; the best model first.
std::optional<ResultTable> recognitionOf(const ModelChoiceResults& results, std::size_t distance,
                                         std::vector<std::string>& notes) {
  std::vector<std::size_t> drives;
  for (std::size_t s = 0; s < results.drives.size(); ++s) {
    if (percentRight(results.cell(distance, s, 0)))
      drives.push_back(s);
    else if (distance == 0)
      notes.push_back(
          fmt::format("{}: no place is seen twice within {:.2g} m, so it says nothing about place "
                      "recognition",
                      results.drives[s].name, results.drives[s].radius));
  }
  if (drives.empty()) return std::nullopt;
  using Of = std::function<double(std::size_t drive)>;
  std::vector<std::pair<std::string, Of>> rows;
  for (std::size_t m = 0; m < results.models.size(); ++m)
    rows.emplace_back(results.models[m],
                      [&, m](std::size_t s) { return 100 * results.cell(distance, s, m).recognition.right; });
  const auto meanOver = [&](const Of& of) {
    std::vector<double> shares;
    for (const std::size_t s : drives) shares.push_back(of(s));
    return meanOf(shares);
  };
  std::stable_sort(rows.begin(), rows.end(),
                   [&](const auto& a, const auto& b) { return meanOver(a.second) > meanOver(b.second); });
  rows.emplace_back("(by chance)",
                    [&](std::size_t s) { return 100 * results.cell(distance, s, 0).recognition.chance; });
  std::vector<Measure<Of>> measures;
  for (const std::size_t s : drives)
    measures.push_back({{results.drives[s].name + " [%]", 1, ResultTable::Best::largest},
                        [s](const Of& of) { return of(s); }});
  measures.push_back({{"mean [%]", 1, ResultTable::Best::largest}, meanOver});
  ResultTable table = pivot<Of>({"Place recognition", "", "model", {}, {}}, rows, measures);
  for (const std::size_t s : drives) {
    const auto& drive = results.drives[s];
    table.caption += fmt::format("{}: {} images, right within {:.2g} m{}. ", drive.name,
                                 results.cell(distance, s, 0).recognition.queries, drive.radius,
                                 drive.again ? ", asked by a second visit" : ", asked by the drive itself");
  }
  table.caption +=
      "Share of images whose most alike other image was taken at the same place. Images whose place is seen "
      "only once do not count.";
  return table;
}

void addDistance(const ModelChoiceResults& results, std::size_t distance,
                 const std::vector<std::size_t>& shown, Findings& findings) {
  std::vector<std::vector<std::vector<double>>> tests;
  for (std::size_t s = 0; s < results.drives.size(); ++s) tests.push_back(testsOf(results, distance, s));
  const std::string by = results.distances.size() > 1 ? ", by " + results.distances[distance] : "";
  const Variances all = compareBy(tests);
  const bool several = tests.size() > 1;

  auto table = tableOf(results, all, shown, (several ? "All sequences" : results.drives[0].name) + by);
  table.caption = fmt::format(
      "Mean spatial variance inside the clusters as a share of the variance of all positions{}; mean rank "
      "and "
      "wins over {} tests: every k{}.",
      several ? ", mean over the sequences" : "", results.drives.size() * tests.front().size(),
      several ? " on every sequence" : "");
  const auto recognized = recognitionOf(results, distance, findings.notes);
  if (distance == 0) {
    findings.summary = fmt::format("{} tells the places apart best (mean rank {:.2f} of {} models)",
                                   results.models[all.order[0]], all.standings[all.order[0]].meanRank,
                                   results.models.size());
    if (recognized)
      findings.summary += fmt::format(", {} recognizes them best ({:.0f} %)", recognized->rows[0].name,
                                      *recognized->rows[0].values.back());
    findings.summary += ".";
  }
  findings.sections.emplace_back(std::move(table));
  auto chart = chartOf(results, all, "Spatial variance inside clusters" + by);
  chart.caption =
      "Images are clustered by their labels alone. The lower the curve, the closer together the images "
      "of a cluster were taken.";
  findings.sections.emplace_back(std::move(chart));
  findings.sections.emplace_back(barsOf(results, all));
  if (recognized) {
    findings.sections.emplace_back(*recognized);
    std::get<ResultTable>(findings.sections.back()).title += by;
  }
  if (!several) return;
  for (std::size_t s = 0; s < tests.size(); ++s) {
    const Variances one = compareBy({tests[s]});
    const double meters = results.cell(distance, s, 0).variance[0].overItems;
    auto own = tableOf(results, one, shown, results.drives[s].name + by);
    own.caption = fmt::format("{} images; 100 % are {:.3g} m².", results.drives[s].frames, meters);
    findings.sections.emplace_back(std::move(own));
    findings.sections.emplace_back(chartOf(results, one, results.drives[s].name + by));
  }
}

}  // namespace

std::vector<std::string> ModelChoiceCell::measures() {
  return {varianceName, byImageName, queriesName, rightName, chanceName};
}

CellResults ModelChoiceCell::toResults() const {
  CellResults results;
  for (std::size_t k = 1; k <= variance.size(); ++k) {
    results.push_back({varianceName, std::to_string(k), variance[k - 1].overClusters});
    results.push_back({byImageName, std::to_string(k), variance[k - 1].overItems});
  }
  results.push_back({queriesName, "", static_cast<double>(recognition.queries)});
  results.push_back({rightName, "", recognition.right});
  results.push_back({chanceName, "", recognition.chance});
  return results;
}

ModelChoiceCell ModelChoiceCell::fromResults(const CellResults& results) {
  ModelChoiceCell cell;
  for (const CellResult& result : results) {
    if (result.measure == varianceName) cell.variance.push_back({result.value, 0});
    if (result.measure == byImageName && !cell.variance.empty())
      cell.variance.back().overItems = result.value;
    if (result.measure == queriesName) cell.recognition.queries = static_cast<std::size_t>(result.value);
    if (result.measure == rightName) cell.recognition.right = result.value;
    if (result.measure == chanceName) cell.recognition.chance = result.value;
  }
  return cell;
}

Findings findingsOf(const ModelChoiceResults& results, const std::vector<std::size_t>& shown) {
  Findings findings;
  findings.title = "Which model fits?";
  for (const auto& drive : results.drives)
    findings.facts.emplace_back("Sequence",
                                fmt::format("{}, {} images with a pose", drive.name, drive.frames));
  for (std::size_t d = 0; d < results.distances.size(); ++d) addDistance(results, d, shown, findings);
  return findings;
}

ResultTable besideThesis(const ModelChoiceResults& results) {
  const ThesisTable printed = readThesisTable(thesisModelChoiceCsv, 1);
  ResultTable table{
      "Beside the thesis (Table 4.1)",
      "Mean spatial variance inside k clusters, mean over the sequences. The thesis' rows are of "
      "the twelve sequences of KTH-IDOL2's Minnie.",
      "model",
      {},
      {}};
  for (const std::string& k : printed.columns)
    table.columns.push_back({fmt::format("k = {} [10⁻² m²]", k), 2});
  for (std::size_t d = 0; d < results.distances.size(); ++d)
    for (std::size_t m = 0; m < results.models.size(); ++m) {
      auto& row = table.rows.emplace_back(
          ResultTable::Row{fmt::format("{}, {}", results.models[m], results.distances[d]), {}});
      for (const std::string& column : printed.columns) {
        const std::size_t k = std::stoul(column);
        std::vector<double> variances;
        for (std::size_t s = 0; s < results.drives.size() && k <= commonClusters(results); ++s)
          variances.push_back(100 * results.cell(d, s, m).variance[k - 1].overClusters);
        row.values.push_back(variances.empty() ? CellValue() : meanOf(variances));
      }
    }
  for (const ThesisTable::Row& row : printed.rows)
    table.rows.push_back({fmt::format("(thesis: {})", row.name()), row.values});
  return table;
}

}  // namespace estancia::experiments
