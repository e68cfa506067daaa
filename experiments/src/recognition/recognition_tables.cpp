#include "experiments/src/recognition/recognition_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "experiments/src/recognition/thesis_means_checked.hpp"
#include "experiments/src/recognition/thesis_recognition.hpp"

namespace estancia::experiments {
namespace {

using Values = std::vector<std::optional<double>>;

constexpr std::array scores{kVerified, kCorrect, kFalsePositives};

class Tables {
 public:
  explicit Tables(const RecognitionResults& results) : r_(results) {}

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
      for (const char* what : {"thesis", kVerified.name, kCorrect.name, kFalsePositives.name})
        table.columns.push_back({fmt::format("{}: {}", filter, what), 1});
    for (std::size_t d = 0; d < r_.descriptors.size(); ++d)
      for (std::size_t k = 0; k < r_.keypoints.size(); ++k) {
        Values values;
        for (const std::string& filter : filters) {
          values.push_back(thesisOverallOf(d, k, filter));
          for (const RecognitionScore& score : scores) {
            std::vector<double> all;
            for (std::size_t m = 0; m < r_.modelFilters.size(); ++m)
              for (std::size_t n = 0; n < r_.noises.size(); ++n)
                for (std::size_t f = 0; f < r_.sceneFilters.size(); ++f)
                  if (r_.sceneFilters[f].first == filter) all.push_back(score.of(r_.cell(p, k, d, m, n, f)));
            values.push_back(meanOf(all));
          }
        }
        table.rows.push_back({fmt::format("{}, {}", r_.descriptors[d], r_.keypoints[k]), std::move(values)});
      }
    findings.sections.emplace_back(std::move(table));
  }

  void addAll(Findings& findings) const {
    bool comparable = false;
    for (std::size_t d = 0; d < r_.descriptors.size(); ++d) {
      for (std::size_t k = 0; k < r_.keypoints.size(); ++k) {
        for (std::size_t p = 0; p < r_.presets.size(); ++p)
          for (const RecognitionScore& score : scores)
            findings.sections.emplace_back(cells(p, {k}, d, score));
        if (auto table = thesisTable(k, d)) {
          comparable = true;
          findings.sections.emplace_back(std::move(*table));
        }
      }
      addMeans(d, findings);
    }
    if (comparable) findings.sections.emplace_back(thesisMeansChecked());
  }

 private:
  ResultTable empty(const std::string& title, const std::string& rowsAre) const {
    ResultTable table{title, "", rowsAre, {}, {}, 100};
    for (const auto& filter : r_.sceneFilters) table.columns.push_back({nameOf(filter), 0});
    return table;
  }

  /// The thesis' layout; the mean over `keypoints`.
  ResultTable cells(std::size_t p, const std::vector<std::size_t>& keypoints, std::size_t d,
                    const RecognitionScore& score) const {
    ResultTable table = empty(titleOf(r_, p, d,
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
          for (const std::size_t k : keypoints) all.push_back(score.of(r_.cell(p, k, d, m, n, f)));
          values.push_back(meanOf(all));
        }
        table.rows.push_back({fmt::format("{}, {}", r_.modelFilters[m], millimeters(r_.noises[n])), values});
      }
    return table;
  }

  /// The same, and the mean over the noise.
  ResultTable sizes(std::size_t p, std::size_t d, const RecognitionScore& score) const {
    ResultTable table = empty(
        titleOf(r_, p, d, fmt::format("mean of the keypoint detectors and noises: percent {}", score.name)),
        "models");
    for (std::size_t m = 0; m < r_.modelFilters.size(); ++m) {
      Values values;
      for (std::size_t f = 0; f < r_.sceneFilters.size(); ++f) {
        std::vector<double> all;
        for (std::size_t k = 0; k < r_.keypoints.size(); ++k)
          for (std::size_t n = 0; n < r_.noises.size(); ++n)
            all.push_back(score.of(r_.cell(p, k, d, m, n, f)));
        values.push_back(meanOf(all));
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
      for (const RecognitionScore& score : scores) {
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

  /// Rows are model filters, by noise where there are as many.
  static ResultTable thesisLayout(const std::string& title, const std::vector<int>& percent) {
    ResultTable table{title, "Percent of the thesis' 49 pairs that were verified.", "models, noise", {}, {},
                      100};
    for (const auto& filter : thesisSceneFilters()) table.columns.push_back({nameOf(filter), 0});
    const std::size_t columns = table.columns.size(), rows = percent.size() / columns,
                      perModel = rows / thesisModelFilters().size();
    for (std::size_t row = 0; row < rows; ++row) {
      Values values;
      for (std::size_t c = 0; c < columns; ++c) values.emplace_back(percent[row * columns + c]);
      const std::string& model = thesisModelFilters()[row / perModel];
      table.rows.push_back(
          {perModel == 1 ? model : fmt::format("{}, {}", model, millimeters(thesisNoises()[row % perModel])),
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

  const RecognitionResults& r_;
};

}  // namespace

void addOverall(const RecognitionResults& results, Findings& findings) {
  for (std::size_t p = 0; p < results.presets.size(); ++p) Tables(results).addOverall(p, findings);
}

void addThesisTables(const RecognitionResults& results, Findings& findings) {
  Tables(results).addAll(findings);
}

}  // namespace estancia::experiments
