// Frame poses: where the camera stood at each frame of a map, which may have left frames out.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "estancia/core/pose.hpp"

namespace estancia {

/// Poses by the numbers of their frames, in order. Frames that are left out are gaps and take no memory.
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
  void truncate(std::size_t size) {
    if (size >= next_) return;
    entries_.resize(indexOf(size));
    next_ = size;
  }
  /// Replaces the pose of a frame; ignored if that frame is left out.
  void set(std::size_t frame, const std::optional<Pose>& pose) {
    const std::size_t at = indexOf(frame);
    if (isAt(at, frame)) entries_[at].pose = pose;
  }
  /// Leaves out all frames but these, which are sorted.
  void keepOnly(std::span<const std::size_t> frames) {
    auto kept = frames.begin();
    std::erase_if(entries_, [&](const Entry& entry) {
      while (kept != frames.end() && *kept < entry.frame) ++kept;
      return kept == frames.end() || *kept != entry.frame;
    });
    entries_.shrink_to_fit();
  }

  /// Nothing where the frame has none, is left out, or has not come yet.
  const std::optional<Pose>& operator[](std::size_t frame) const {
    static const std::optional<Pose> unknown;
    const std::size_t at = indexOf(frame);
    return isAt(at, frame) ? entries_[at].pose : unknown;
  }
  /// Pose of the last added frame.
  const std::optional<Pose>& back() const { return entries_.back().pose; }

 private:
  /// Where the frame is, or would be.
  std::size_t indexOf(std::size_t frame) const {
    if (isAt(frame, frame)) return frame;  // no gaps before it
    return static_cast<std::size_t>(std::ranges::lower_bound(entries_, frame, {}, &Entry::frame) -
                                    entries_.begin());
  }
  bool isAt(std::size_t index, std::size_t frame) const {
    return index < entries_.size() && entries_[index].frame == frame;
  }

  std::vector<Entry> entries_;
  std::size_t next_ = 0;
};

}  // namespace estancia
