// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/purposes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estancia/words/label_relevance.hpp"
#include "estancia/words/word_graph.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"
#include "words/tiny_wordnet.hpp"

namespace estancia {
namespace {

/// How well the first meaning of a thing, as a kind of all that it is, serves the words.
double shareOf(const WordGraph& graph, const std::string& thing, const std::vector<std::string>& words) {
  std::vector<std::vector<Sense>> terms;
  for (const std::string& word : words) terms.push_back(graph.lexicon.senses(word));
  const auto hypernyms = graph.hypernyms(graph.lexicon.senses(thing).front().synset);
  std::vector<std::uint32_t> things;
  for (const auto& [above, distance] : hypernyms) things.push_back(above);
  return inheritedShare(purposeShares(graph, terms, things), hypernyms);
}

double realShare(const std::string& thing, const std::vector<std::string>& words) {
  return shareOf(test::realWords(), thing, words);
}

TEST(Purposes, AreVerbsAfterToAndFor) {
  const test::ScratchFolder folder;
  test::WordNetTexts texts = test::tinyWordNet();
  const auto define = [&](const std::string& before, const std::string& after) {
    std::string& nouns = texts.at("data.noun");
    nouns.replace(nouns.find(before), before.size(), after);
  };
  define("a thing that is moved by hand", "for washing and cooking an animal");
  define("it cuts in the kitchen", "for the cook, who cooks; to a wash; \"used to cook\"");
  test::writeWordNet(texts, folder.path());
  const WordGraph graph = buildWordGraph(readWordNet(folder.path()));
  EXPECT_GT(shareOf(graph, "kitchen", {"cook"}), 0.9) << "a room to cook in";
  EXPECT_EQ(shareOf(graph, "kitchen", {"wash"}), 0);
  EXPECT_EQ(shareOf(graph, "stove", {"cook"}), 0) << "a thing on which a cook cooks";
  EXPECT_GT(shareOf(graph, "computer mouse", {"wash"}), 0.9);
  EXPECT_GT(shareOf(graph, "computer mouse", {"cook"}), 0.9);
  EXPECT_GT(shareOf(graph, "computer mouse", {"wash", "animal"}), 0.9);
  EXPECT_EQ(shareOf(graph, "computer mouse", {"animal"}), 0) << "no verb";
  EXPECT_NEAR(shareOf(graph, "kitchen", {"cook", "quickly"}), 0.5, 0.05) << "one word of two";
  EXPECT_EQ(shareOf(graph, "knife", {"cook"}), 0) << "a person; an example";
  EXPECT_EQ(shareOf(graph, "knife", {"wash"}), 0) << "to a place";
}

TEST(Purposes, AreInherited) {
  EXPECT_GT(realShare("folding chair", {"sit"}), 0.8) << "a seat is designed for sitting on";
  EXPECT_GT(realShare("fountain pen", {"write"}), 0.8) << "a writing implement is used to write";
  EXPECT_GT(realShare("lawn mower", {"cut", "grass"}), 0.8) << "who mows, cuts";
  EXPECT_GT(realShare("dishwasher", {"wash", "dishes"}), realShare("washing machine", {"wash", "dishes"}));
  EXPECT_LT(realShare("table lamp", {"sit"}), 0.1) << "that it sits on a table is no purpose";
  EXPECT_EQ(realShare("dog", {"sit"}), 0);
}

}  // namespace
}  // namespace estancia
