// Word cloud, and bars of words: the most probable words of a place or a zone (thesis Fig. 4.9).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/descriptor.hpp"
#include "estancia/core/vocabulary.hpp"
#include "estancia/figures/color.hpp"
#include "estancia/figures/svg.hpp"
#include "estancia/words/label_concepts.hpp"

namespace estancia::report {

struct PlacedWord {
  std::string text;
  double size = 0;  ///< size of the font
  Box box;          ///< estimated extent, which the drawn word is made to keep
};

/// Packs words on a spiral from the middle of a width×height box; sizes grow with the square root of the
/// weights. Weights must be positive and descending. Boxes never overlap and stay inside; words that fit at
/// no readable size are left out.
std::vector<PlacedWord> packWords(const std::vector<std::pair<std::string, double>>& words, double width,
                                  double height);

/// These words in an <svg> of 340×150. Weights must be positive and descending.
Markup wordCloud(const std::vector<std::pair<std::string, double>>& words);

/// The 25 most probable words.
Markup wordCloud(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView mean);

/// An <ol> of at most `count` words (familiarWords()), most probable first; bars are relative to the best.
/// The labels of a word are its title. With `sigma` (one value a label, empty for none) the probability of a
/// label is given ± its standard deviation; that of several together is not known.
Markup labelBars(const Vocabulary& vocabulary, const LabelConcepts& concepts, DescriptorView mean,
                 DescriptorView sigma, std::size_t count);

}  // namespace estancia::report
