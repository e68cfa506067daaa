// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/frame_poses.hpp"

#include <algorithm>

namespace estancia {

std::size_t FramePoses::indexOf(std::size_t frame) const {
  if (isAt(frame, frame)) return frame;  // no gaps before it
  return static_cast<std::size_t>(std::ranges::lower_bound(entries_, frame, {}, &Entry::frame) -
                                  entries_.begin());
}

void FramePoses::truncate(std::size_t size) {
  if (size >= next_) return;
  entries_.resize(indexOf(size));
  next_ = size;
}

void FramePoses::set(std::size_t frame, const std::optional<Pose>& pose) {
  const std::size_t at = indexOf(frame);
  if (isAt(at, frame)) entries_[at].pose = pose;
}

void FramePoses::keepOnly(std::span<const std::size_t> frames) {
  auto kept = frames.begin();
  std::erase_if(entries_, [&](const Entry& entry) {
    while (kept != frames.end() && *kept < entry.frame) ++kept;
    return kept == frames.end() || *kept != entry.frame;
  });
  entries_.shrink_to_fit();
}

const std::optional<Pose>& FramePoses::operator[](std::size_t frame) const {
  static const std::optional<Pose> unknown;
  const std::size_t at = indexOf(frame);
  return isAt(at, frame) ? entries_[at].pose : unknown;
}

}  // namespace estancia
