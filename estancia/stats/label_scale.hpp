// What a run's own labels are like: the center and the spread that standardized distances measure by.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/stats/distance.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia {

/// How a run's own labels are centered and weighted before they are compared; both empty: not at all.
struct Standardization {
  std::vector<float> center;
  std::vector<float> weight;  ///< ≥ 0; about 1/σ of the label, 0 for one that never says anything
};

/// By the embedded descriptors that `moments` (with spread) has seen, each as heavy as the next and in
/// whatever order they came.
Standardization standardizationBy(const Moments& moments);

/// Watches a run and tells each label's center and weight.
///
/// Only keyframes count: frames that differ from the last keyframe by more than a camera's noise. So a robot
/// that stands or waits teaches nothing, and the frame rate hardly matters.
class LabelScale {
 public:
  LabelScale(Distance distance, std::size_t labels);

  /// The next frame: its probabilities, and the same embedded. Returns whether it is a keyframe.
  bool add(std::span<const float> probabilities, std::span<const float> embedded);

  /// By all keyframes so far; empty unless the distance is standardized; neutral while the robot has seen
  /// hardly anything.
  Standardization standardization() const;
  /// False while nothing but noise has been seen.
  bool hasSeenEnough() const;

  /// What was seen, as numbers of frames.
  struct Memory {
    std::size_t frames = 0, keyframes = 0;
    std::size_t views = 0;  ///< frames that showed something new
    std::size_t lastView = 0,
                repeats = 0;  ///< the frame that showed something new last, and how many like it
  };
  const Memory& memory() const { return memory_; }
  /// Of the keyframes' embedded descriptors.
  const Moments& moments() const { return moments_; }
  /// `lastView` are the probabilities of that frame; empty when there was none.
  void restore(Memory memory, Moments moments, std::vector<float> lastView);

 private:
  bool counts(std::span<const float> probabilities, std::span<const float> embedded);

  Distance distance_;
  std::size_t labels_;
  Memory memory_;
  Moments moments_;
  std::vector<float> lastView_;  ///< its centered log-ratios
};

}  // namespace estancia
