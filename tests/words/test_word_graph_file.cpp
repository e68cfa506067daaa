// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_graph_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

TEST(WordGraphFile, BringsTheGraphBack) {
  const WordGraph graph = tinyGraph();
  const std::string bytes = packWordGraph(graph, "a WordNet");
  const WordGraph back = unpackWordGraph(bytes, "a WordNet", "words.graph");
  EXPECT_EQ(back.lexicon.senseSynsets, graph.lexicon.senseSynsets);
  EXPECT_EQ(back.nameText, graph.nameText);
  EXPECT_EQ(back.edgeTargets, graph.edgeTargets);
  EXPECT_FALSE(back.purposes.synsets.empty());
  EXPECT_EQ(back.degrees, graph.degrees);
  EXPECT_EQ(packWordGraph(back, "a WordNet"), bytes);
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

}  // namespace
}  // namespace estancia
