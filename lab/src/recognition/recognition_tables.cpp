// SPDX-License-Identifier: Apache-2.0
#include "recognition/recognition_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "findings/pivot.hpp"
#include "findings/thesis.hpp"

namespace estancia::experiments {
namespace {

using Place = RecognitionResults::Place;

constexpr std::array scores{verifiedScore, correctScore, falsePositiveScore};

ResultTable headOf(const RecognitionResults& r, const std::string& title, const std::string& rowsAre) {
  std::vector<std::string> filters;
  for (const auto& filter : r.sceneFilters) filters.push_back(nameOf(filter));
  return {title, "", rowsAre, columnsOf(filters, 0), {}, 100};
}

/// The thesis' layout: model filters and noises down, scene filters across; the mean over the detectors, or
/// that of one.
ResultTable byNoise(const RecognitionResults& r, std::size_t preset, std::optional<std::size_t> keypoint,
                    std::size_t descriptor, const RecognitionScore& score) {
  std::vector<std::string> rows;
  for (const std::string& filter : r.modelFilters)
    for (const double noise : r.noises) rows.push_back(fmt::format("{}, {}", filter, millimeters(noise)));
  const std::string of = keypoint ? r.keypoints[*keypoint] : "mean of the keypoint detectors";
  return pivot(headOf(r, titleOf(r, preset, descriptor, fmt::format("{}: percent {}", of, score.name)),
                      "models, noise"),
               rows, [&](std::size_t row, std::size_t column) {
                 return r.mean(score, [&](const Place& at) {
                   return at.preset == preset && at.descriptor == descriptor && at.sceneFilter == column &&
                          at.modelFilter == row / r.noises.size() && at.noise == row % r.noises.size() &&
                          at.keypoint == keypoint.value_or(at.keypoint);
                 });
               });
}

/// Results by size: the mean over the noises, too.
ResultTable bySize(const RecognitionResults& r, std::size_t preset, std::size_t descriptor,
                   const RecognitionScore& score) {
  const std::string title =
      titleOf(r, preset, descriptor,
              fmt::format("mean of the keypoint detectors and noises: percent {}", score.name));
  return pivot(headOf(r, title, "models"), r.modelFilters, [&](std::size_t row, std::size_t column) {
    return r.mean(score, [&](const Place& at) {
      return at.preset == preset && at.descriptor == descriptor && at.modelFilter == row &&
             at.sceneFilter == column;
    });
  });
}

/// Adds the thesis' tables of a descriptor and a detector, or of the means of the detectors.
void addThesis(const std::string& descriptor, const std::string& keypoint, Findings& findings) {
  const ThesisTable thesis = readThesisTable(thesisRecognitionCsv, 5);
  ResultTable* table = nullptr;
  std::string number;
  for (const auto& row : thesis.rows) {
    if (row.keys[1] != descriptor || row.keys[2] != keypoint) continue;
    const bool ofNoises = row.keys[4] == "mean";
    if (row.keys[0] != number) {
      number = row.keys[0];
      const std::string what = ofNoises             ? "the same, mean of the noises"
                               : keypoint == "mean" ? descriptor + ", mean of the keypoint detectors"
                                                    : descriptor + ", " + keypoint;
      findings.sections.emplace_back(ResultTable{fmt::format("The thesis' {}: {}", number, what),
                                                 "Percent of the thesis' 49 pairs that were verified.",
                                                 "models, noise",
                                                 columnsOf(thesis.columns, 0),
                                                 {},
                                                 100});
      table = &std::get<ResultTable>(findings.sections.back());
    }
    table->rows.push_back(
        {ofNoises ? row.keys[3] : fmt::format("{}, {}", row.keys[3], millimeters(std::stod(row.keys[4]))),
         row.values});
  }
}

/// Table 2.17 in all scores.
ResultTable overall(const RecognitionResults& r, std::size_t preset) {
  const ThesisTable thesis = readThesisTable(thesisRecognitionMeansCsv, 2);
  const std::size_t own = r.thesisTables ? 1 : 0;  // the first column that is not the thesis'
  std::vector<std::string> filters;
  for (const auto& [method, points] : r.sceneFilters)
    if (std::find(filters.begin(), filters.end(), method) == filters.end()) filters.push_back(method);
  ResultTable head{
      fmt::format("{}By descriptor, detector and filter of the scenes (Table 2.17)",
                  r.presets.size() > 1 ? r.presets[preset] + ": " : ""),
      fmt::format("Mean percent over {} model filters, {} noise levels and the sizes.{}",
                  r.modelFilters.size(), r.noises.size(),
                  r.thesisTables
                      ? " The thesis' is over three model filters, six noise levels up to 10 mm and four "
                        "sizes, and counts what is verified."
                      : ""),
      "descriptor, keypoints",
      {},
      {},
      100};
  for (const std::string& filter : filters) {
    if (r.thesisTables) head.columns.push_back({filter + ": thesis", 1});
    for (const RecognitionScore& score : scores)
      head.columns.push_back({fmt::format("{}: {}", filter, score.name), 1});
  }
  std::vector<std::string> rows;
  for (const std::string& descriptor : r.descriptors)
    for (const std::string& keypoint : r.keypoints) rows.push_back(descriptor + ", " + keypoint);
  const std::size_t perFilter = own + scores.size();
  return pivot(std::move(head), rows, [&](std::size_t row, std::size_t column) -> CellValue {
    const std::size_t d = row / r.keypoints.size(), k = row % r.keypoints.size();
    const std::string& filter = filters[column / perFilter];
    if (column % perFilter < own) return thesis.find({r.descriptors[d], r.keypoints[k]}, filter);
    return r.mean(scores[column % perFilter - own], [&](const Place& at) {
      return at.preset == preset && at.descriptor == d && at.keypoint == k &&
             r.sceneFilters[at.sceneFilter].first == filter;
    });
  });
}

/// Fig. 2.9 in both scores: what is verified is either correct or stands elsewhere.
StackedBars barsOf(const ResultTable& table) {
  StackedBars bars{table.title + ", as bars (Fig. 2.9)",
                   "The thesis counts what is verified, wherever it stands.",
                   {"correct", "verified, elsewhere or not known where", "not verified"},
                   {}};
  const std::size_t perFilter = 1 + scores.size();  // the thesis, verified, correct, false positives
  for (const auto& [name, values] : table.rows)
    for (std::size_t c = 0; c < values.size(); c += perFilter) {
      const std::string filter =
          name + ", " + table.columns[c].name.substr(0, table.columns[c].name.rfind(':'));
      const double verified = values[c + 1].value_or(0), correct = values[c + 2].value_or(0);
      bars.bars.push_back({filter, {correct, verified - correct, 100 - verified}});
      if (values[c]) bars.bars.push_back({filter + ", thesis", {0, *values[c], 100 - *values[c]}});
    }
  return bars;
}

}  // namespace

void addOverall(const RecognitionResults& results, Findings& findings) {
  for (std::size_t p = 0; p < results.presets.size(); ++p) {
    const ResultTable table = overall(results, p);
    findings.sections.emplace_back(table);
    if (results.thesisTables) findings.sections.emplace_back(barsOf(table));
  }
}

void addByDetector(const RecognitionResults& r, Findings& findings) {
  for (std::size_t d = 0; d < r.descriptors.size(); ++d) {
    for (std::size_t k = 0; k < r.keypoints.size(); ++k) {
      for (std::size_t p = 0; p < r.presets.size(); ++p)
        for (const RecognitionScore& score : scores)
          findings.sections.emplace_back(byNoise(r, p, k, d, score));
      if (r.thesisTables) addThesis(r.descriptors[d], r.keypoints[k], findings);
    }
    if (r.keypoints.size() < 2) continue;
    for (std::size_t p = 0; p < r.presets.size(); ++p)
      for (const RecognitionScore& score : scores) {
        findings.sections.emplace_back(byNoise(r, p, std::nullopt, d, score));
        findings.sections.emplace_back(bySize(r, p, d, score));
      }
    if (r.thesisTables) addThesis(r.descriptors[d], "mean", findings);
  }
}

}  // namespace estancia::experiments
