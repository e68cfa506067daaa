// Frame poses: where the camera stood at each frame of a map, which may have left frames out.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/pose.hpp"

namespace estancia {

/// Poses by the numbers of their frames, in order. Numbers have gaps where frames are left out: these take no
/// memory.
class FramePoses {
 public:
  struct Entry {
    std::size_t frame = 0;
    std::optional<Pose> pose;
  };

  /// One more than the last number.
  std::size_t size() const { return next_; }
  bool empty() const { return next_ == 0; }
  /// In order.
  const std::vector<Entry>& entries() const { return entries_; }

  /// Appends the pose of the next frame.
  void add(const std::optional<Pose>& pose) { entries_.push_back({next_++, pose}); }
  /// The next frame has this number; those before it that were not added are left out. `frame` >= size().
  void skipTo(std::size_t frame) { next_ = frame; }
  /// Takes back the frames from `size` on.
  void truncate(std::size_t size);
  /// Replaces the pose of a frame; ignored if that frame is left out.
  void set(std::size_t frame, const std::optional<Pose>& pose);
  /// Leaves out all frames but these, which are sorted.
  void keepOnly(std::span<const std::size_t> frames);

  /// Nothing where the frame has none, is left out, or has not come yet.
  const std::optional<Pose>& operator[](std::size_t frame) const;
  /// Pose of the last added frame.
  const std::optional<Pose>& back() const { return entries_.back().pose; }

 private:
  /// Where the frame is, or would be.
  std::size_t indexOf(std::size_t frame) const;
  bool isAt(std::size_t index, std::size_t frame) const {
    return index < entries_.size() && entries_[index].frame == frame;
  }

  std::vector<Entry> entries_;
  std::size_t next_ = 0;
};

}  // namespace estancia
