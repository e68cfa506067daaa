#include "experiments/src/recognition/recognition_by_noise.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

namespace estancia::experiments {
namespace {

using Values = std::vector<std::optional<double>>;

constexpr std::size_t mostOverviewRows = 60;

class ByNoise {
 public:
  explicit ByNoise(const RecognitionResults& results) : r_(results) {}

  std::string sentence() const {
    std::string text;
    for (const std::size_t n : {quietest(), noisiest()}) {
      if (!text.empty() && quietest() == noisiest()) break;
      const auto [cell, name] = best(n);
      text +=
          fmt::format("{}{}: at best {} of {} are found where they are, with {} of {} false positives ({}).",
                      text.empty() ? "" : " ",
                      r_.noises[n] == 0 ? "Without noise" : "With noise of " + millimeters(r_.noises[n]),
                      cell->correct, cell->pairs, cell->falsePositives, cell->absent, name);
    }
    return text;
  }

  void addOverviews(Findings& findings) const {
    std::size_t rows = 0;
    each([&](auto...) { ++rows; });
    if (rows < 2 || rows > mostOverviewRows) return;
    for (const RecognitionScore& score : {kCorrect, kFalsePositives, kVerified}) {
      ResultTable table{fmt::format("Percent {}, by noise", score.name), "", "scenes", {}, {}, 100};
      for (const double noise : r_.noises) table.columns.push_back({millimeters(noise), 1});
      each([&](auto p, auto k, auto d, auto m, auto f) {
        Values values;
        for (std::size_t n = 0; n < r_.noises.size(); ++n)
          values.push_back(score.of(r_.cell(p, k, d, m, n, f)));
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
    for (const double noise : r_.noises) seconds.columns.push_back({millimeters(noise), 2});
    each([&](auto p, auto k, auto d, auto m, auto f) {
      Values values;
      for (std::size_t n = 0; n < r_.noises.size(); ++n) values.push_back(r_.cell(p, k, d, m, n, f).seconds);
      seconds.rows.push_back({nameOf(p, k, d, m, f), std::move(values)});
    });
    findings.sections.emplace_back(std::move(seconds));
  }

 private:
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
    if (r_.sceneFilters.size() > 1 || parts.empty()) parts.push_back(experiments::nameOf(r_.sceneFilters[f]));
    return fmt::format("{}", fmt::join(parts, ", "));
  }

  /// The most correct at a noise; of equals the one with the fewest false positives, then the first.
  std::pair<const RecognitionCell*, std::string> best(std::size_t n) const {
    const RecognitionCell* most = nullptr;
    std::string name;
    each([&](auto p, auto k, auto d, auto m, auto f) {
      const RecognitionCell& here = r_.cell(p, k, d, m, n, f);
      if (most != nullptr && (here.correct < most->correct ||
                              (here.correct == most->correct && here.falsePositives >= most->falsePositives)))
        return;
      most = &here;
      name = nameOf(p, k, d, m, f);
    });
    return {most, name};
  }

  const RecognitionResults& r_;
};

}  // namespace

std::string bestByNoise(const RecognitionResults& results) {
  return ByNoise(results).sentence();
}

void addOverviews(const RecognitionResults& results, Findings& findings) {
  ByNoise(results).addOverviews(findings);
}

void addCurves(const RecognitionResults& r, Findings& findings) {
  if (r.noises.size() < 2) return;
  std::vector<std::size_t> order(r.noises.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return r.noises[a] < r.noises[b]; });
  for (std::size_t p = 0; p < r.presets.size(); ++p)
    for (std::size_t d = 0; d < r.descriptors.size(); ++d)
      for (std::size_t m = 0; m < r.modelFilters.size(); ++m) {
        LineChart chart{titleOf(r, p, d, fmt::format("models {}: percent correct", r.modelFilters[m])),
                        r.keypoints.size() > 1 ? "The mean of the keypoint detectors." : "",
                        "noise [mm]",
                        "percent correct",
                        false,
                        {},
                        {},
                        true};
        for (const std::size_t n : order) chart.x.push_back(1000 * r.noises[n]);
        for (std::size_t f = 0; f < r.sceneFilters.size(); ++f) {
          LineChart::Line line{nameOf(r.sceneFilters[f]), {}};
          for (const std::size_t n : order) {
            std::vector<double> all;
            for (std::size_t k = 0; k < r.keypoints.size(); ++k)
              all.push_back(r.cell(p, k, d, m, n, f).correctPercent());
            line.y.push_back(meanOf(all));
          }
          chart.lines.push_back(std::move(line));
        }
        findings.sections.emplace_back(std::move(chart));
      }
}

}  // namespace estancia::experiments
