// Contact sheet: all objects of a folder of views, a view each, with their words (thesis Fig. 6.4).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/findings/findings.hpp"
#include "estancia/readers/object_views.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia {

/// One image an object, as labelers see it: the view that has most of the object's word, a whole one if there
/// is any (neither flat nor cut by the border). The word is the most probable one by the mean of its views
/// that `labels` has, by whole names; `concepts` join labels. Throws Error when a view cannot be read.
Images objectSheet(const ObjectViews& views, const DescriptorSequence* labels = nullptr,
                   const LabelConcepts& concepts = {});

}  // namespace estancia
