// SPDX-License-Identifier: Apache-2.0
#include "recognition/recognition_by_noise.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "findings/pivot.hpp"

namespace estancia::experiments {
namespace {

using Place = RecognitionResults::Place;

constexpr std::size_t maxOverviewRows = 60;

/// The first place, without noise, of everything that was compared at each noise.
std::vector<Place> comparedOf(const RecognitionResults& r) {
  std::vector<Place> all;
  for (std::size_t i = 0; i < r.cells.size(); ++i)
    if (const Place place = r.placeOf(i); place.noise == 0) all.push_back(place);
  return all;
}

const RecognitionCell& cellAt(const RecognitionResults& r, const Place& at, std::size_t noise) {
  return r.cell(at.preset, at.keypoint, at.descriptor, at.modelFilter, noise, at.sceneFilter);
}

/// What is not the same for all.
std::string curveName(const RecognitionResults& r, const Place& at) {
  std::vector<std::string> parts;
  if (r.presets.size() > 1) parts.push_back(r.presets[at.preset]);
  if (r.descriptors.size() > 1) parts.push_back(r.descriptors[at.descriptor]);
  if (r.keypoints.size() > 1) parts.push_back(r.keypoints[at.keypoint]);
  if (r.modelFilters.size() > 1) parts.push_back(fmt::format("{} models", r.modelFilters[at.modelFilter]));
  if (r.sceneFilters.size() > 1 || parts.empty())
    parts.push_back(experiments::nameOf(r.sceneFilters[at.sceneFilter]));
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// The largest number of correct poses at a noise; of equal ones that with the fewest false positives, then
/// the first.
Place bestAt(const RecognitionResults& r, std::size_t noise) {
  const auto all = comparedOf(r);
  return *std::max_element(all.begin(), all.end(), [&](const Place& a, const Place& b) {
    const RecognitionCell &one = cellAt(r, a, noise), &other = cellAt(r, b, noise);
    return std::pair(one.correct, other.falsePositives) < std::pair(other.correct, one.falsePositives);
  });
}

}  // namespace

std::string bestByNoise(const RecognitionResults& r) {
  const auto [least, most] = std::minmax_element(r.noises.begin(), r.noises.end());
  std::vector<std::string> sentences;
  for (const auto noise : {least, std::max_element(r.noises.begin(), r.noises.end())}) {
    const auto n = static_cast<std::size_t>(noise - r.noises.begin());
    const Place best = bestAt(r, n);
    const RecognitionCell& cell = cellAt(r, best, n);
    sentences.push_back(
        fmt::format("{}: at best {} of {} are found where they are, with {} of {} false positives ({}).",
                    *noise == 0 ? "Without noise" : "With noise of " + millimeters(*noise), cell.correct,
                    cell.pairs, cell.falsePositives, cell.absent, curveName(r, best)));
    if (*least == *most) break;
  }
  return fmt::format("{}", fmt::join(sentences, " "));
}

void addOverviews(const RecognitionResults& r, Findings& findings) {
  const auto compared = comparedOf(r);
  if (compared.size() < 2 || compared.size() > maxOverviewRows) return;
  std::vector<std::string> rows, noises;
  for (const Place& place : compared) rows.push_back(curveName(r, place));
  for (const double noise : r.noises) noises.push_back(millimeters(noise));
  for (const RecognitionScore& score : {correctScore, falsePositiveScore, verifiedScore})
    findings.sections.emplace_back(pivot(
        {fmt::format("Percent {}, by noise", score.name), "", "scenes", columnsOf(noises, 1), {}, 100}, rows,
        [&](std::size_t row, std::size_t noise) { return score.of(cellAt(r, compared[row], noise)); }));
  findings.sections.emplace_back(pivot(
      {"Seconds a pair, by noise",
       "On one thread; the scene's filter and description are paid by every pair, models are ready.",
       "scenes",
       columnsOf(noises, 2),
       {}},
      rows, [&](std::size_t row, std::size_t noise) { return cellAt(r, compared[row], noise).seconds; }));
}

void addCurves(const RecognitionResults& r, Findings& findings) {
  if (r.noises.size() < 2) return;
  const auto order = ascending(r.noises.size(), [&](std::size_t n) { return r.noises[n]; });
  std::vector<RecognitionScore> scores{correctScore};
  if (r.thesisTables) scores.push_back(verifiedScore);  // Fig. 2.6 to 2.8
  for (std::size_t p = 0; p < r.presets.size(); ++p)
    for (std::size_t d = 0; d < r.descriptors.size(); ++d)
      for (std::size_t m = 0; m < r.modelFilters.size(); ++m)
        for (const RecognitionScore& score : scores) {
          const std::string name = fmt::format("percent {}", score.name);
          LineChart chart{titleOf(r, p, d, fmt::format("models {}: {}", r.modelFilters[m], name)),
                          r.keypoints.size() > 1 ? "The mean of the keypoint detectors." : "",
                          "noise [mm]",
                          name,
                          false,
                          {},
                          {},
                          true};
          for (const std::size_t n : order) chart.x.push_back(1000 * r.noises[n]);
          for (std::size_t f = 0; f < r.sceneFilters.size(); ++f) {
            auto& line =
                chart.lines.emplace_back(LineChart::Line{experiments::nameOf(r.sceneFilters[f]), {}});
            for (const std::size_t n : order)
              line.y.push_back(r.mean(score, [&](const Place& at) {
                return at.preset == p && at.descriptor == d && at.modelFilter == m && at.noise == n &&
                       at.sceneFilter == f;
              }));
          }
          findings.sections.emplace_back(std::move(chart));
        }
}

}  // namespace estancia::experiments
