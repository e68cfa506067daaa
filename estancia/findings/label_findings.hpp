// Label findings: which labels the images of a sequence have, how often, and which image shows one best.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "estancia/findings/findings.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"

namespace estancia {

struct LabelFindingsOptions {
  /// An image has its so many most probable labels; those of probability 0 it has not.
  std::size_t labelsPerImage = 20;
  /// Labels in the table, and in the cloud ten times as many.
  std::size_t tableRows = 40;
  /// Labels whose best images are shown.
  std::size_t imageLabels = 12;
  /// Images of each.
  std::size_t imagesPerLabel = 3;
};

/// The file (PNG or JPEG) of a frame's image, empty where there is none.
using ImageOfFrame = std::function<std::vector<unsigned char>(std::size_t frame)>;

/// Tag cloud, frequencies and most telling images of the labels (thesis Fig. 3.6, 3.12, 3.13). Throws Error
/// (insufficientData) where no image has a label. O(images · labels).
Findings labelFindings(const DescriptorSequence& sequence, const ImageOfFrame& image = {},
                       const LabelFindingsOptions& options = {});

}  // namespace estancia
