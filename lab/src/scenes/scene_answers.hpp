// Scene answers: the answers of one classifier about one test, with accuracy and interval.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runner/grid.hpp"

namespace estancia::experiments {

/// Images whose rooms are known, in runs: images of one run show the same room, taken one after another, and
/// are no independent witnesses.
struct SceneTest {
  /// The true one of each image, 0 …
  std::vector<int> rooms;
  /// Run of each image, 0 …
  std::vector<int> runs;
  /// Number of rooms in truths and answers.
  int roomCount = 0;
  int runCount = 0;
};

/// A share with the interval that covers the true one 19 times in 20.
struct Share {
  double value = 0, low = 0, high = 0;
};

/// The share of right answers: Wilson's interval (J. Am. Stat. Assoc. 22 (1927)), with the number of
/// independent images that carry as much information (Kish's effective sample size, from the variance between
/// runs; Korn & Graubard, Survey Methodology 24 (1998), with their correction for few runs by Student's t).
/// Where all or none are right, each run counts as one image. `right[i]` in [0, 1], one an image. Throws
/// Error when there are no images.
Share shareRight(const SceneTest& test, const std::vector<double>& right);

/// What one cell found: an answer an image, for each seed.
struct SceneAnswers {
  /// [seed][image]: the number of a room.
  std::vector<std::vector<int>> answers;

  /// Share of the seeds that were right about each image.
  std::vector<double> right(const SceneTest& test) const;
  /// Right answers in each run, of all seeds: whole numbers, so that equals are equal however they are
  /// summed.
  std::vector<std::size_t> rightInRuns(const SceneTest& test) const;
  double accuracy(const SceneTest& test) const;
  /// Mean over the rooms that the test shows of the share of their images that were recognized.
  double balancedAccuracy(const SceneTest& test) const;
  /// rooms × rooms, the true one a row: images, a mean over the seeds.
  std::vector<double> confusion(const SceneTest& test) const;

  CellResults toResults(const SceneTest& test) const;
  /// Throws Error when these are not `seeds` answers for each of the images of `test`.
  static SceneAnswers fromResults(const CellResults& results, const SceneTest& test, std::size_t seeds);
};

}  // namespace estancia::experiments
