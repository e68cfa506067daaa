// Familiar words: what is likely, in the words that people use, "dog" for five breeds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia {

/// A label, or several that one word stands for.
struct FamiliarWord {
  std::string name;
  /// Most probable first.
  std::vector<std::size_t> labels;
  /// The sum of its labels', at most 1.
  float probability = 0;
};

/// The `count` most probable words, best first. A concept stands for its labels where at least two of them
/// are more probable than by chance (1/L, at most 0.01; noise of a hundred breeds is no dog), and the sum of
/// these times its specificity is more than the best of them. Labels of the same name, of several models, are
/// one word. Without concepts, each label is a word of its own. A label is in one word at most.
std::vector<FamiliarWord> familiarWords(const Vocabulary& vocabulary, const LabelConcepts& concepts,
                                        DescriptorView mean, std::size_t count);

/// For people, as where the name of a place is missing: "stove, oven", the two words that distinguish it from
/// the run (tellingWords()), else the most probable one. Without concepts, the most probable label.
std::string familiarTitle(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView here,
                          DescriptorView run);

}  // namespace estancia
