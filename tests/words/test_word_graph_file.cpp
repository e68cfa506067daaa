// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_graph_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estancia/words/label_search.hpp"
#include "support/errors.hpp"
#include "words/tiny_wordnet.hpp"

namespace estancia {
namespace {

using test::FailsWith;

WordGraph tinyGraph() {
  const test::ScratchFolder folder;
  test::writeWordNet(test::tinyWordNet(), folder.path());
  return buildWordGraph(readWordNet(folder.path()));
}

/// Whatever a graph is asked for.
void useAll(const WordGraph& graph) {
  const Vocabulary vocabulary({"dog, domestic dog", "kitchen", "computer mouse", "T-shirt"});
  const LabelSearch search(vocabulary, &graph);
  for (const char* words : {"animal", "rooms", "something to cook", "mice", "kichen", "zzz"})
    search.search(words, 20, 0);
  for (std::uint32_t synset = 0; synset < graph.size(); ++synset) {
    graph.name(synset);
    graph.pos(synset);
    graph.category(synset);
    graph.hypernyms(synset);
  }
  for (std::size_t i = 0; i < graph.lexicon.size(); ++i) graph.lexicon.senses(graph.lexicon.word(i));
}

TEST(WordGraphFile, BringsTheGraphBack) {
  const WordGraph graph = tinyGraph();
  const std::string bytes = packWordGraph(graph, "a WordNet");
  const WordGraph back = unpackWordGraph(bytes, "a WordNet", "words.graph");
  EXPECT_EQ(back.lexicon.text, graph.lexicon.text);
  EXPECT_EQ(back.lexicon.starts, graph.lexicon.starts);
  EXPECT_EQ(back.lexicon.senseStarts, graph.lexicon.senseStarts);
  EXPECT_EQ(back.lexicon.senseSynsets, graph.lexicon.senseSynsets);
  EXPECT_EQ(back.lexicon.senseWeights, graph.lexicon.senseWeights);
  EXPECT_EQ(back.lexicon.frequencies, graph.lexicon.frequencies);
  EXPECT_EQ(back.lexicon.firstSynset, graph.lexicon.firstSynset);
  EXPECT_EQ(back.nameText, graph.nameText);
  EXPECT_EQ(back.nameStarts, graph.nameStarts);
  EXPECT_EQ(back.categories, graph.categories);
  EXPECT_EQ(back.offsets, graph.offsets);
  EXPECT_EQ(back.edgeStarts, graph.edgeStarts);
  EXPECT_EQ(back.edgeTargets, graph.edgeTargets);
  EXPECT_EQ(back.edgeWeights, graph.edgeWeights);
  EXPECT_EQ(back.edgeLinks, graph.edgeLinks);
  EXPECT_EQ(back.purposes.starts, graph.purposes.starts);
  EXPECT_EQ(back.purposes.synsets, graph.purposes.synsets);
  EXPECT_EQ(back.purposes.shares, graph.purposes.shares);
  EXPECT_FALSE(back.purposes.synsets.empty());
  EXPECT_EQ(back.degrees, graph.degrees);
  EXPECT_EQ(back.degreeSum, graph.degreeSum);
  EXPECT_EQ(packWordGraph(back, "a WordNet"), bytes);
  useAll(back);
}

TEST(WordGraphFile, IsRefusedWhenItIsOfAnotherWordNetOrVersion) {
  std::string bytes = packWordGraph(tinyGraph(), "a WordNet");
  EXPECT_THAT([&] { unpackWordGraph(bytes, "another", "words.graph"); },
              FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { unpackWordGraph("ESTWORDX" + bytes.substr(8), "a WordNet", "words.graph"); },
              FailsWith(ErrorCode::malformedFile));
  ++bytes[8];
  EXPECT_THAT([&] { unpackWordGraph(bytes, "a WordNet", "words.graph"); },
              FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { unpackWordGraph("", "a WordNet", "words.graph"); }, FailsWith(ErrorCode::truncatedFile));
}

TEST(WordGraphFile, IsRefusedWhenAWeightIsNone) {
  const WordGraph sound = tinyGraph();
  for (const float weight : {0.0F, -1.0F, 1e30F, std::nanf(""), INFINITY}) {
    WordGraph graph = sound;
    graph.edgeWeights.back() = weight;
    WordGraph other = sound;
    other.lexicon.senseWeights.front() = weight;
    WordGraph third = sound;
    third.purposes.shares.front() = weight;
    for (const WordGraph& damaged : {graph, other, third})
      EXPECT_THAT([&] { unpackWordGraph(packWordGraph(damaged, ""), "", "words.graph"); },
                  FailsWith(ErrorCode::corruptFile));
  }
}

TEST(WordGraphFile, CanBeUsedOrIsRefusedWhateverIsDamaged) {
  const std::string sound = packWordGraph(tinyGraph(), "");
  std::mt19937 random(41);
  int refused = 0;
  for (int round = 0; round < 500; ++round) {
    std::string bytes = sound;
    for (unsigned edits = 1 + random() % 3; edits > 0; --edits) {
      const std::size_t at = 16 + random() % (bytes.size() - 16);
      bytes[at] = random() % 3 == 0 ? '\xff' : static_cast<char>(random());
    }
    try {
      useAll(unpackWordGraph(bytes, "", "words.graph"));
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace estancia
