// Thresholds that a run finds for itself: what is near in time against what is far in time.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "estancia/stats/distance.hpp"
#include "estancia/topology/moments.hpp"
#include "estancia/topology/node_bank.hpp"

namespace estancia {

struct ThresholdOptions {
  double farQuantile =
      0.03;  ///< τ_join accepts this share of pairs of different places; larger: larger places
  double revisitRatio = 0.4;  ///< τ_revisit = this · τ_join: moving needs more evidence than staying
  double mergeRatio = 0.3;    ///< τ_merge = this · τ_join, between the means of two nodes; 0: never merge
};

struct Thresholds {
  double join = 0, revisit = 0, merge = 0;
};

/// τ_join and what follows from it.
Thresholds thresholdsFrom(double tauJoin, const ThresholdOptions& options);

/// Watches a run without ground truth and tells its scales: each label's mean and σ, and the thresholds.
///
/// A bounded sample of frames, evenly spread over the run, gives two sets of distances: between frames one or
/// two apart (near in time) and between frames far apart. Most far pairs show different places, so their
/// lower quantile bounds how often two places may pass for one. Where the robot came back, some far pairs
/// show the same place; their share is read off the near pairs (twice the share of far pairs below the near
/// median) and the quantile moves up by it.
class RunScale {
 public:
  RunScale(Distance distance, std::size_t labels, ThresholdOptions options);

  /// The next frame's embedded descriptor.
  void add(std::span<const float> embedded);
  std::size_t frames() const { return frames_; }

  /// Labels' centre and scale by all frames so far; empty unless the distance is standardized.
  Standardization standardization() const;

  /// Absent while the run is too short to have frames that are far apart.
  std::optional<Thresholds> estimate(const Standardization& standardization) const;

  /// For --continue: the frames the sample would hold after `frames` frames, in order.
  static std::vector<std::size_t> sampledFrames(std::size_t frames);
  /// Restores the state after `frames` frames from the moments and the sampled frames' embedded descriptors.
  void restore(std::size_t frames, Moments moments, std::map<std::size_t, std::vector<float>> sample);
  const Moments& moments() const { return moments_; }

 private:
  static std::size_t strideAfter(std::size_t frames);

  Distance distance_;
  std::size_t labels_;
  ThresholdOptions options_;
  std::size_t frames_ = 0;
  Moments moments_;
  std::map<std::size_t, std::vector<float>> sample_;  ///< frame → embedded descriptor
};

}  // namespace estancia
