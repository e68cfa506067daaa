// What is a kind of what stays known in the word graph, also where definitions name it.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/words/word_graph.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(WordKinds, AreKeptWhereTheDefinitionNamesThemToo) {
  WordNet wordNet;
  const auto add = [&](std::uint32_t offset, const std::string& word, const std::string& gloss) {
    WordNetSynset synset;
    synset.offset = offset;
    synset.words = {word};
    synset.tagCounts = {1};
    synset.gloss = gloss;
    wordNet.entries.push_back(
        {word, PartOfSpeech::noun, {static_cast<std::uint32_t>(wordNet.synsets.size())}});
    wordNet.synsets.push_back(std::move(synset));
  };
  add(100, "seat", "furniture");
  add(200, "chair", "a seat with a back");
  add(300, "rocking chair", "a chair on rockers");
  for (const std::uint32_t below : {1U, 2U}) {
    wordNet.synsets[below].relations = {{"@", PartOfSpeech::noun, below - 1}};
    wordNet.synsets[below - 1].relations.push_back({"~", PartOfSpeech::noun, below});
  }
  const WordGraph graph = buildWordGraph(wordNet);
  EXPECT_THAT(graph.hypernyms(2), ElementsAre(Pair(2, 0), Pair(1, 1), Pair(0, 2)));
  EXPECT_THAT(graph.hypernyms(0), ElementsAre(Pair(0, 0)));
}

}  // namespace
}  // namespace estancia
