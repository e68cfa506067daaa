// Lost drive: whether the robot is in what the map knows, or in another building. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <string>

#include "estancia/core/bytes.hpp"
#include "estancia/stats/label_prior.hpp"
#include "estancia/stats/label_scale.hpp"
#include "estancia/stats/moments.hpp"

namespace estancia {

/// A drive that begins anywhere, until it is recognized. By the scale of the map all images of another
/// building look alike, since they differ from the map's in one direction, and so do its places. So an image
/// shows a place of the map only where it resembles that one, too, with labels scaled as if map and drive had
/// as many images (commonStandardization()), and the drive is in the map when most of its last keyframes do.
///
/// Made when a further drive begins, destroyed when the drive is recognized. Each keyframe is passed to
/// add(), then to count(). Invariant: last_ holds the newest counted keyframes (at most maxCounted) in order;
/// alike_ and unlike_ count all of them.
class LostDrive {
 public:
  /// `map`: of the keyframes of the drives before, with that τ_join. Places from the id `firstNode` on are
  /// the drive's own.
  LostDrive(Moments map, double tauJoin, std::size_t firstFrame, int firstNode);

  std::size_t firstFrame() const { return firstFrame_; }
  int firstNode() const { return firstNode_; }
  bool isOwn(int node) const { return node >= firstNode_; }

  /// A keyframe of the drive, embedded.
  void add(std::span<const float> embedded);
  Standardization scale(const LabelPrior& prior) const { return commonStandardization(map_, drive_, prior); }
  /// Whether the last image was a keyframe, and is to be counted.
  bool isDue() const { return isDue_; }
  /// How far it is from the view of the map that it resembles most, by that scale.
  void count(std::size_t frame, double away);
  bool isRecognized() const;
  /// Recognized after most of the drive was outside the map: the frames there become a part of their own.
  bool cameFromElsewhere() const { return isRecognized() && unlike_ > alike_; }
  /// The frame from which on most resemble the map.
  std::size_t cameBack() const;

  /// Notes that the drive was mapped alone when the map had so many frames.
  void noteMapped(std::size_t frames) { mapped_ = frames; }
  bool isMapped(std::size_t frames) const { return mapped_ == frames; }

  std::string toBytes() const;
  /// Reads the state for a map with so many frames and node ids. Throws Error (corruptFile).
  static LostDrive from(ByteReader& in, std::size_t labels, std::size_t frames, int nodes);

 private:
  Moments map_, drive_;
  double tauJoin_;
  std::size_t firstFrame_;
  int firstNode_;
  struct Keyframe {
    std::size_t frame;
    bool isAlike;
  };
  std::deque<Keyframe> last_;
  std::size_t alike_ = 0, unlike_ = 0, mapped_ = 0;
  bool isDue_ = false;
};

}  // namespace estancia
