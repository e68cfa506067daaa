// Recognition results: counts of the recognition experiment, by everything that it compared.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runner/grid.hpp"

namespace estancia::experiments {

/// Counts over all pairs and seeds.
struct RecognitionCell {
  std::size_t seeds = 0, pairs = 0, verified = 0, correct = 0;
  /// Instances of models that are there, beyond their true poses.
  std::size_t extra = 0;
  std::size_t absent = 0, falsePositives = 0;
  /// Searches, present or absent, with nothing to describe.
  std::size_t failed = 0;
  std::vector<std::size_t> correctBySeed;
  /// Mean a pair; the filter is a part of it.
  double seconds = 0, filterSeconds = 0;
  /// Mean a pair, beside it.
  double modelSeconds = 0;

  /// Columns of results.csv.
  static std::vector<std::string> measures();
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
constexpr RecognitionScore verifiedScore{"verified", &RecognitionCell::verifiedPercent},
    correctScore{"correct", &RecognitionCell::correctPercent},
    falsePositiveScore{"false positives", &RecognitionCell::falsePercent};

/// Why searches failed.
struct RecognitionFailure {
  std::string reason;
  /// The first such search: "mug in table".
  std::string first;
  /// Number of searches.
  std::size_t count = 0;
};

struct RecognitionResults {
  /// Method, and the points that it leaves; 0: all.
  using SceneFilter = std::pair<std::string, std::size_t>;

  std::vector<std::string> presets, keypoints, descriptors, modelFilters;
  std::vector<SceneFilter> sceneFilters;
  std::vector<double> noises;
  /// ((((preset · keypoints + k) · descriptors + d) · modelFilters + m) · noises + n) · sceneFilters + s
  std::vector<RecognitionCell> cells;
  /// Different reasons, as far as they are known.
  std::vector<RecognitionFailure> failures;
  /// The thesis' numbers beside.
  bool thesisTables = false;

  /// Which of each list a cell is of.
  struct Place {
    std::size_t preset = 0, keypoint = 0, descriptor = 0, modelFilter = 0, noise = 0, sceneFilter = 0;
  };
  Place placeOf(std::size_t cell) const;
  /// The mean over the cells whose place is wanted, in their order.
  double mean(const RecognitionScore& score, const std::function<bool(const Place&)>& wanted) const;

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

}  // namespace estancia::experiments
