// Bag summary: the topics of a bag, how regular they are, and which a map would be made of.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/sequences/sequence.hpp"

namespace estancia {

struct TopicSummary {
  std::string name, type;
  std::size_t messages = 0;
  /// Messages a second, and the longest time without one [s], by when they were recorded; 0 for less than
  /// two.
  double rate = 0, longestGap = 0;
  /// Use of the topic: "images", "depth", "camera", "camera of depth", "poses"; "" for nothing.
  std::string use;
  /// Why it is used.
  std::string why;
};

struct BagSummary {
  std::vector<TopicSummary> topics;
  /// From the first message to the last [s].
  double duration = 0;
  /// Why it has no images to use, as a sentence; "" where it has.
  std::string whyNoImages;
  /// Faults of the file: it is cut off, a part is missing …
  std::vector<std::string> warnings;
};

/// Throws Error as openSequence() does for bags, but not for want of images.
BagSummary summarizeBag(const std::filesystem::path& bag, const SequenceOptions& options = {});

}  // namespace estancia
