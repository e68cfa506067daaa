// Pseudo-labels: from class probabilities to the classes that shapes are learned by.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "estancia/objects/class_probabilities.hpp"
#include "estancia/objects/training.hpp"

namespace estancia {

/// One class a sample; −1: none, not to be learned from (no probability for any class, or not trusted; voted:
/// none for the whole instance). `instances` identifies the samples of one object; `shapes` (of the same
/// samples) and `options` are for PseudoLabeling::confident alone, which equals top with fewer than two
/// classes, and keeps samples of classes that cannot be held out. Throws Error (mismatch) when the numbers of
/// samples differ; Interrupted.
std::vector<int> assignPseudoLabels(PseudoLabeling labeling, const ClassProbabilities& answers,
                                    std::span<const int> instances, const Features& shapes,
                                    const ClassifierOptions& options, Progress& progress = Progress::none());

}  // namespace estancia
