// Threshold estimation: label scales and thresholds of a run, online and without ground truth. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "estancia/distances/distance.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/stats/label_prior.hpp"
#include "estancia/stats/label_scale.hpp"

namespace estancia {

/// τ_join and what follows from it.
Thresholds thresholdsFrom(double tauJoin, const ThresholdOptions& options);

/// Estimates each label's center and weight, and the thresholds.
///
/// A bounded sample, blocks of consecutive keyframes evenly spread over the run, gives two sets of distances:
/// between keyframes one or two apart (near in time) and between keyframes far apart. Most far pairs show
/// different places, so their lower quantile bounds how often two places may pass for one. Where the robot
/// came back, some far pairs show the same place; their share is read off the near pairs (twice the share of
/// far pairs below the near median) and the quantile moves up by it.
///
/// A run of few places cannot show this: half of the far pairs between two rooms show one of these. There the
/// prior gives the distance between places. It is right for descriptors about the mean of all places, and the
/// run's are about the mean of its own: K places are 1/(K − 1) further apart about their own mean (a regular
/// simplex). K − 1 is the participation ratio of the blocks' means, over which the views of one place have
/// been averaged. The run's own quantile counts by the pairs of places within it.
class ThresholdEstimator {
 public:
  ThresholdEstimator(Distance distance, std::size_t labels, ThresholdOptions options, LabelPrior prior);

  /// The next frame: its probabilities, and the same embedded. Returns whether it is a keyframe.
  bool add(std::span<const float> probabilities, std::span<const float> embedded);
  std::size_t frames() const { return labels_.memory().frames; }
  std::size_t keyframes() const { return labels_.memory().keyframes; }

  /// See LabelScale.
  Standardization standardization() const { return labels_.standardization(); }

  /// Thresholds before the first frame.
  Thresholds initial() const;
  /// Absent while the run is too short to have keyframes that are far apart.
  std::optional<Thresholds> estimate(const Standardization& standardization) const;

  /// To go on later: what was seen, as frame numbers.
  struct Memory : LabelScale::Memory {
    std::map<std::size_t, std::size_t> sampled;  ///< keyframe number → frame number
  };
  Memory memory() const { return {labels_.memory(), sampled_}; }
  /// Moments of the keyframes' embedded descriptors.
  const Moments& moments() const { return labels_.moments(); }
  /// `probabilities(i)` gives frame i's stored descriptor.
  void restore(Memory memory, Moments moments,
               const std::function<std::vector<float>(std::size_t)>& probabilities);

 private:
  /// Keyframe number → as frames and nodes are compared.
  using Compared = std::map<std::size_t, std::vector<float>>;
  static std::size_t strideAfter(std::size_t keyframes);
  std::optional<double> tauOfRun(const Compared& compared) const;
  static std::size_t changeLength(const Compared& compared);
  double placesSpanned(const Compared& compared) const;

  Distance distance_;
  ThresholdOptions options_;
  LabelPrior prior_;
  LabelScale labels_;
  std::map<std::size_t, std::size_t> sampled_;        ///< keyframe number → frame number
  std::map<std::size_t, std::vector<float>> sample_;  ///< keyframe number → embedded descriptor
};

}  // namespace estancia
