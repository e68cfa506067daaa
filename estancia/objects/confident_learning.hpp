// Confident learning: finds label errors by held-out class probabilities (Northcutt, Jiang, Chuang 2021).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia {

/// Samples that are likely mislabeled (Northcutt, Jiang, Chuang, JAIR 70, 2021, section 3), ascending. A
/// sample counts for the most probable of the classes whose probability is at least the mean self-confidence
/// of that class's samples; the counts of (label, other class) estimate the number of errors, and that many
/// samples are taken (pruning by noise rate), those with the largest margin of the other class first, and
/// only where it is more probable than the label. `labels` are 0 … K − 1, `heldOut` N × K probabilities; rows
/// of zeros are not judged. Throws Error (mismatch) when the numbers of samples differ.
std::vector<std::size_t> likelyMislabeled(const std::vector<int>& labels, const DescriptorMatrix& heldOut);

}  // namespace estancia
