// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "estancia/words/label_search.hpp"
#include "estancia/words/word_files.hpp"
#include "estancia/words/wordnet.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

static void search(const WordGraph& graph) {
  const Vocabulary vocabulary({"dog, domestic dog", "kitchen", "computer mouse"});
  const LabelSearch search(vocabulary, &graph);
  for (const char* words : {"animal", "something to cook", "kichen"}) search.search(words, 20, 0);
  for (std::uint32_t synset = 0; synset < graph.size(); ++synset) graph.hypernyms(synset);
}

FUZZ_TARGET(words, wordnet) {
  static constexpr std::array names{"index.noun", "index.verb", "index.adj",  "index.adv", "data.noun",
                                    "data.verb",  "data.adj",   "data.adv",   "noun.exc",  "verb.exc",
                                    "adj.exc",    "adv.exc",    "cntlist.rev"};
  const auto files = parts(bytes, names.size());
  for (std::size_t i = 0; i < names.size(); ++i) inputFile(names[i], files[i]);
  search(buildWordGraph(readWordNet(folder())));
}

/// Made from WordNet, and kept in the cache.
FUZZ_TARGET(words, word_graph) {
  search(unpackWordGraph(bytes, "WordNet", "words.graph"));
}

FUZZ_TARGET(words, word_associations) {
  unpackAssociationsFile(bytes, "WordNet", 3, "associations.words");
}

}  // namespace estancia::fuzz
