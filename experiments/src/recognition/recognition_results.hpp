// What the recognition experiment counted, by everything that it compared.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/src/runner/grid.hpp"

namespace estancia::experiments {

/// Counts over all pairs and seeds.
struct RecognitionCell {
  std::size_t seeds = 0, pairs = 0, verified = 0, correct = 0;
  std::size_t absent = 0, falsePositives = 0;
  std::size_t failed = 0;  ///< of both: nothing to describe
  std::vector<std::size_t> correctBySeed;
  double seconds = 0, filterSeconds = 0;  ///< mean a pair; the filter is a part of it
  double modelSeconds = 0;                ///< mean a pair, beside it

  static std::vector<std::string> measures();  ///< those of results.csv
  CellResults toResults() const;

  double verifiedPercent() const { return percent(verified, pairs); }
  double correctPercent() const { return percent(correct, pairs); }
  double falsePercent() const { return percent(falsePositives, absent); }

 private:
  static double percent(std::size_t part, std::size_t whole) {
    return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
  }
};

/// A share of the cases.
struct RecognitionScore {
  const char* name;
  double (RecognitionCell::*percent)() const;
  double of(const RecognitionCell& cell) const { return (cell.*percent)(); }
};
constexpr RecognitionScore kVerified{"verified", &RecognitionCell::verifiedPercent},
    kCorrect{"correct", &RecognitionCell::correctPercent},
    kFalsePositives{"false positives", &RecognitionCell::falsePercent};

/// Why searches failed.
struct RecognitionFailure {
  std::string reason;
  std::string first;      ///< of them: "mug in table"
  std::size_t count = 0;  ///< of searches
};

struct RecognitionResults {
  using SceneFilter = std::pair<std::string, std::size_t>;  ///< and the points it leaves; 0: all

  std::vector<std::string> presets, keypoints, descriptors, modelFilters;
  std::vector<SceneFilter> sceneFilters;
  std::vector<double> noises;
  /// ((((preset · keypoints + k) · descriptors + d) · modelFilters + m) · noises + n) · sceneFilters + s
  std::vector<RecognitionCell> cells;
  std::vector<RecognitionFailure> failures;  ///< different reasons, as far as they are known

  std::size_t indexOf(std::size_t preset, std::size_t keypoint, std::size_t descriptor,
                      std::size_t modelFilter, std::size_t noise, std::size_t sceneFilter) const {
    return ((((preset * keypoints.size() + keypoint) * descriptors.size() + descriptor) *
                 modelFilters.size() +
             modelFilter) *
                noises.size() +
            noise) *
               sceneFilters.size() +
           sceneFilter;
  }
  const RecognitionCell& cell(std::size_t preset, std::size_t keypoint, std::size_t descriptor,
                              std::size_t modelFilter, std::size_t noise, std::size_t sceneFilter) const {
    return cells[indexOf(preset, keypoint, descriptor, modelFilter, noise, sceneFilter)];
  }
};

/// "gng 20000", "none".
std::string nameOf(const RecognitionResults::SceneFilter& filter);

/// "thesis: shot, " and the rest; the preset's name only where there are several.
std::string titleOf(const RecognitionResults& results, std::size_t preset, std::size_t descriptor,
                    const std::string& rest);

/// "5 mm" of 0.005.
std::string millimeters(double meters);

/// Of some values.
double meanOf(const std::vector<double>& values);

}  // namespace estancia::experiments
