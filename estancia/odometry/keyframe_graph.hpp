// Keyframe graph: the images among which a camera is tracked, which were aligned, and the poses that agree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/odometry/alignment.hpp"
#include "estancia/odometry/frame_view.hpp"
#include "estancia/odometry/pose_graph.hpp"
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

/// Whether an alignment is to be believed.
bool isGood(const Alignment& alignment, double minOverlap = 0.35);

/// Keyframes are its nodes. Edges belong to the later of their keyframes, which is their source; they are
/// added in the order of these.
class KeyframeGraph {
 public:
  enum class Kind : std::uint8_t {
    tracked,  ///< from one keyframe to the next
    loop,     ///< by aligning keyframes of other times
    assumed   ///< not from an image: the prior's motion, or a guess where tracking was lost
  };
  struct Edge : PoseGraphEdge {
    Kind kind = Kind::tracked;
    double off = 0;  ///< after optimize() [standard deviations]
  };

  const std::vector<Edge>& edges() const { return edges_; }
  void add(const PoseGraphEdge& edge, Kind kind);
  /// Takes those of the last keyframe away.
  void removeEdgesOf(std::size_t keyframe);
  /// The earlier keyframe to which keyframe k was tracked or guessed: where the last edge before loops leads.
  std::size_t referenceOf(std::size_t k) const;
  /// Whether both were aligned with each other.
  bool connects(std::size_t later, std::size_t earlier) const { return aligned_.contains({later, earlier}); }

  /// Whether nothing was aligned with keyframe k.
  bool isAlone(std::size_t k) const;
  /// Whether more than one edge leads from keyframe k to earlier ones, so that these may contradict.
  bool isOverdetermined(std::size_t k) const;
  /// Aligned, and not in contradiction to the others.
  static bool isSeen(const Edge& edge);

  /// Moves the keyframes to the optimum of all edges, after those of the latest keyframe were added: only
  /// keyframes near it, unless it closes a long loop.
  void optimize(Keyframes& keyframes);
  /// The other keyframes that are known to be near: those that edges connect with k, and with these (at most
  /// `reach` edges away), but for loops that contradict the others. At most `max`, the most closely connected
  /// first. Ignores the keyframe `without`.
  std::vector<std::size_t> around(std::size_t k, std::size_t max, std::size_t reach = 2,
                                  std::optional<std::size_t> without = {}) const;
  /// Number of the part of every keyframe: those that alignments connect, directly or not. It is the first
  /// keyframe of the part.
  std::vector<std::size_t> parts(std::size_t keyframes) const;

  /// Edges of keyframe k, and back; without the results of optimize().
  void write(std::size_t k, ByteWriter& bytes) const;
  /// Throws Error (malformedFile).
  void read(std::size_t k, ByteReader& bytes);
  void setOff(std::size_t edge, double off) { edges_[edge].off = off; }

 private:
  std::vector<bool> toMove(std::size_t keyframes) const;

  std::vector<Edge> edges_;
  std::vector<std::vector<std::size_t>> ofNode_;  ///< numbers of the edges that end there
  std::set<std::pair<std::size_t, std::size_t>> aligned_;
};

/// The poses of keyframes as reported last. The optimum of the pose graph moves by fractions of a millimeter
/// with every keyframe. Who fuses what was seen at a pose need not do it again for that. Invariant: told_
/// holds the pose of each keyframe as it was last reported, which differs from the optimum by less than the
/// tolerance. Life cycle: update() after each optimization; `revision()` grows when a reported pose changes.
class MapPoses {
 public:
  /// T_map_keyframe; nothing for keyframes that are not in the map, the part with the most frames.
  const std::optional<cv::Affine3d>& at(std::size_t k) const { return told_[k]; }
  std::uint64_t revision() const { return revision_; }
  /// Whether both keyframes belong to one part, as of the last update.
  bool areJoined(std::size_t a, std::size_t b) const { return part_[a] == part_[b]; }

  /// How many frames belong to its part, as of the last update.
  std::size_t framesOfPartOf(std::size_t k) const { return partFrames_[part_[k]]; }

  /// Counts frames that depend on keyframe k.
  void count(std::size_t k, std::ptrdiff_t frames);
  /// Whether another part than the map has the most frames now.
  bool isOutgrown() const { return outgrown_; }

  /// Reports the poses of new keyframes; and the optimum of all when it moves what an earlier one shows by
  /// more than `tolerance` [m], or other keyframes belong to the map.
  void update(const Keyframes& keyframes, const KeyframeGraph& graph, double tolerance);
  void removeLast();

  void write(ByteWriter& bytes) const;
  /// Takes the place of update() and of count(). Throws Error (malformedFile).
  void read(const KeyframeGraph& graph, std::vector<std::size_t> framesOf, ByteReader& bytes);

 private:
  void countParts(const KeyframeGraph& graph, std::size_t keyframes);

  std::vector<std::optional<cv::Affine3d>> told_;
  std::uint64_t revision_ = 0;
  std::size_t map_ = 0;  ///< the part that was reported
  bool outgrown_ = false;
  std::vector<std::size_t> frames_;      ///< frame of each keyframe
  std::vector<std::size_t> part_;        ///< part of each keyframe, as of the last update
  std::vector<std::size_t> partFrames_;  ///< by the part's number
};

/// All 16 numbers of a transform, so that it comes back to the last bit.
void write(const cv::Affine3d& transform, ByteWriter& bytes);
/// Throws Error (malformedFile) when they are not finite.
cv::Affine3d readTransform(ByteReader& bytes);

}  // namespace estancia::odometry
