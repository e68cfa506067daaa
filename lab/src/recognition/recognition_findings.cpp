// SPDX-License-Identifier: Apache-2.0
#include "recognition/recognition_findings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "recognition/recognition_by_noise.hpp"
#include "recognition/recognition_tables.hpp"

namespace estancia::experiments {
namespace {

/// " Why: …", the few reasons that most searches failed for; "" where none is known.
std::string reasonsOf(std::vector<RecognitionFailure> failures) {
  constexpr std::size_t few = 3;
  std::stable_sort(
      failures.begin(), failures.end(),
      [](const RecognitionFailure& a, const RecognitionFailure& b) { return a.count > b.count; });
  std::string text;
  for (std::size_t i = 0; i < std::min(few, failures.size()); ++i)
    text += fmt::format("{} “{}” ({} times, as {})", i == 0 ? " Why:" : ";", failures[i].reason,
                        failures[i].count, failures[i].first);
  if (failures.size() > few) text += fmt::format("; and {} more", failures.size() - few);
  return text;
}

}  // namespace

Findings findingsOf(const RecognitionResults& results) {
  Findings findings;
  findings.title = "Objects in noise";
  findings.summary = bestByNoise(results);
  addOverviews(results, findings);
  addOverall(results, findings);
  addCurves(results, findings);
  addByDetector(results, findings);
  std::size_t failed = 0, all = 0;
  for (const RecognitionCell& cell : results.cells) {
    failed += cell.failed;
    all += cell.pairs + cell.absent;
  }
  if (failed > 0)
    findings.notes.push_back(
        fmt::format("In {} of {} cases the scene or the model had nothing that could be described; they "
                    "count as not found.{}",
                    failed, all, reasonsOf(results.failures)));
  return findings;
}

}  // namespace estancia::experiments
