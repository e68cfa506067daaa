// Word cloud: words, larger with their probability (thesis Fig. 4.6).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "estancia/figures/html.hpp"
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

}  // namespace estancia::report
