// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/installed_words.hpp"

namespace estancia {

OptionGroup declare(NamingOptions& options) {
  using Words = NamingOptions::Words;
  OptionGroup group("naming", "Which words name zones and areas.");
  group.add("words", options.words,
            {{{"wordnet", "\"dog\" for several breeds, where WordNet is installed"}, Words::wordNet},
             {{"raw", "the labels as the network has them"}, Words::raw}},
            "The words that zones and areas are called by.");
  return group;
}

}  // namespace estancia
