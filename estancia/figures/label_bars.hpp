// Label bars: the most probable labels of a place or a zone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/figures/html.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia::report {

/// An <ol> of at most `count` words (familiarWords()), most probable first; bars are relative to the best.
/// The labels of a word are its title. With `sigma` (one value a label, empty for none) the probability of a
/// label is given ± its standard deviation; that of several together is not known.
Markup labelBars(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView mean,
                 DescriptorView sigma, std::size_t count);

}  // namespace estancia::report
