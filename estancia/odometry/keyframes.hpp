// Keyframes: the images among which a camera is tracked, and between which loops are closed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/odometry/frame_view.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia::odometry {

/// About 90 kB at 160 × 120 pixels.
struct Keyframe {
  std::size_t frame = 0;
  cv::Affine3d pose;  ///< T_map_keyframe
  PackedImage image;
  CoarseView coarse;
  Features features;
  std::vector<float> words;  ///< its descriptor as it is compared; empty without words
};

/// The numbers of the at most `max` smallest values, ascending.
std::vector<std::size_t> smallest(std::vector<std::pair<double, std::size_t>> numbered, std::size_t max);

/// Words are compared as in maps (standardized-clr, the best in measurements), standardized by the keyframes
/// so far. Keyframes without words are never similar to others.
class Keyframes {
 public:
  explicit Keyframes(const std::vector<LabelPart>& parts)
      : distance_(getDistance("standardized-clr", parts)) {}

  std::size_t size() const { return keyframes_.size(); }
  const Keyframe& operator[](std::size_t k) const { return keyframes_[k]; }
  const cv::Affine3d& pose(std::size_t k) const { return keyframes_[k].pose; }
  void move(std::size_t k, const cv::Affine3d& pose) { keyframes_[k].pose = pose; }

  /// Computed from the stored image; the latest few are cached, for the tracking thread alone.
  const Pyramid& pyramid(std::size_t k) const;
  /// Computes the pyramid without the cache: for any thread.
  Pyramid newPyramid(std::size_t k) const { return pyramidOf(keyframes_[k].image); }

  /// Returns its number. Throws Error (mismatch) when the number of words changes.
  std::size_t add(std::size_t frame, const FrameView& view, const cv::Affine3d& pose,
                  const LexicalDescriptor& words);
  void removeLast();

  /// At most `max` of `candidates` that a view at `pose` (T_map_view) overlaps, the most first.
  std::vector<std::size_t> overlapped(const CoarseView& view, const cv::Affine3d& pose,
                                      std::span<const std::size_t> candidates, std::size_t max) const;

  /// At most `max` keyframes with the most similar words, and with those most similar to keyframe k's, of
  /// those at least `apart` before it.
  std::vector<std::size_t> withWords(const LexicalDescriptor& words, std::size_t max) const;
  std::vector<std::size_t> withWordsOf(std::size_t k, std::size_t apart, std::size_t max) const;

  /// All of keyframe k but its pose, and back.
  void write(std::size_t k, ByteWriter& bytes) const;
  /// Throws Error (malformedFile).
  void read(ByteReader& bytes);

 private:
  std::vector<float> embedded(const LexicalDescriptor& words) const;
  void countWords(const std::vector<float>& words);
  std::vector<std::size_t> nearest(const std::vector<float>& words, std::size_t max,
                                   const std::function<bool(std::size_t)>& eligible) const;

  std::vector<Keyframe> keyframes_;
  Distance distance_;
  std::optional<Moments> moments_;  ///< moments of the keyframes with words; absent while none has
  mutable std::vector<std::pair<std::size_t, std::unique_ptr<const Pyramid>>> cached_;
};

}  // namespace estancia::odometry
