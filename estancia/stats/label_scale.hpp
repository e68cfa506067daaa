// Label standardization: center and scale of each label, and descriptors prepared by them to be compared.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/label_prior.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia {

/// Center and weight of each label; both empty: labels are compared as they are.
struct Standardization {
  std::vector<float> center;
  /// ≥ 0; about 1/σ of the label, 0 for a constant one.
  std::vector<float> weight;
};

/// From the moments (with variance) of embedded descriptors, and what is known of the labels.
Standardization standardizationBy(const Moments& moments, const LabelPrior& prior = {});

/// Standardization for comparing the images of two runs, each with equal weight: by the scale of a long run
/// all images of another building look alike, since they differ from its own in one direction.
Standardization commonStandardization(const Moments& a, const Moments& b, const LabelPrior& prior = {});

/// Estimates each label's center and weight online.
///
/// Only keyframes count: frames that differ from the last one by more than the camera's noise. So a robot
/// that stands still changes nothing, and the frame rate hardly matters. A prior counts as some keyframes.
class LabelScale {
 public:
  LabelScale(Distance distance, std::size_t labels, LabelPrior prior = {});

  /// The next frame: its probabilities, and the same embedded. Returns whether it is a keyframe.
  bool add(std::span<const float> probabilities, std::span<const float> embedded);

  /// From all keyframes; empty unless the distance is standardized; neutral without prior or hasSeenEnough().
  Standardization standardization() const;
  /// False while all frames differ by noise only.
  bool hasSeenEnough() const;

  /// Numbers of frames.
  struct Memory {
    std::size_t frames = 0, keyframes = 0;
    /// Frames that differ from the one before.
    std::size_t views = 0;
    /// The last of them, and how many equal frames followed.
    std::size_t lastView = 0, repeats = 0;
  };
  const Memory& memory() const { return memory_; }
  /// Moments of the keyframes' embedded descriptors.
  const Moments& moments() const { return moments_; }
  /// `lastView` are the probabilities of that frame; empty without one.
  void restore(Memory memory, Moments moments, std::vector<float> lastView);

 private:
  bool counts(std::span<const float> probabilities, std::span<const float> embedded);

  Distance distance_;
  std::size_t labels_;
  LabelPrior prior_;
  Memory memory_;
  Moments moments_;
  std::vector<float> lastView_;  // its centered log-ratios
};

/// Prepares one embedded descriptor for compare(): centered and weighted by `standardization` (unless that is
/// empty), its parts weighted, and of unit length for a cosine.
std::vector<float> comparedVector(const Distance& distance, const Standardization& standardization,
                                  std::span<const float> embedded);

/// Embeds descriptors, then prepares each as above. N×L.
DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const Distance& distance,
                                 const Standardization& standardization);

/// Prepares descriptors as a map compares them by `distance`, which has their parts: embedded, for a
/// standardized distance centered and scaled by the run `scale`, then as comparedVector(). N×L.
DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const DescriptorMatrix& scale,
                                 const Distance& distance);

/// Prepares descriptors as zones compare them: standardized, if at all, by all of them in any order. N×L.
DescriptorMatrix comparedVectors(const DescriptorMatrix& descriptors, const Distance& distance);

}  // namespace estancia
