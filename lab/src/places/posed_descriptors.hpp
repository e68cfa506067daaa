// Posed descriptors: a labeled sequence whose camera positions are known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/sequences/sequence.hpp"
#include "places/spatial_variance.hpp"

namespace estancia::experiments {

/// The frames whose position is known, in driving order; the three lists belong together.
struct PosedDescriptors {
  explicit PosedDescriptors(const Vocabulary& vocabulary)
      : parts(vocabulary.layout().parts), descriptors(vocabulary.size()) {}

  /// Their numbers in the sequence.
  std::vector<std::size_t> frames;
  std::vector<Position> positions;
  /// Parts of the descriptors.
  std::vector<LabelPart> parts;
  DescriptorMatrix descriptors;
  /// Frames that could not be read, which are left out.
  std::size_t unreadable = 0;

  /// Gives every descriptor zeros at its end, for labels that have been discovered since.
  void widen(const Vocabulary& vocabulary);

  /// SHA-256 over the lists: two that have the same lead to the same results.
  std::string digest() const;
};

/// Labels the sequence. Throws Error when no frame with a pose can be read, Interrupted when the user asks to
/// stop. Every descriptor has as many values as the labeler knows labels in
/// the end.
PosedDescriptors labelPosed(const Sequence& sequence, Labeler& labeler, LabelCache* cache, Progress& progress,
                            const std::string& what);

}  // namespace estancia::experiments
