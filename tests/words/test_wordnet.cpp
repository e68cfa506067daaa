// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/word_graph.hpp"
#include "estancia/words/wordnet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>

#include "estancia/core/error.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/word_files.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"
#include "words/real_words.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using Edges = std::map<std::pair<std::uint32_t, std::uint32_t>, float>;
using test::FailsWith;
using test::tinyWordNet;
using testing::ElementsAre;
using testing::Pair;

WordNet readTexts(const test::WordNetTexts& texts) {
  const test::ScratchFolder folder;
  test::writeWordNet(texts, folder.path());
  return readWordNet(folder.path());
}

/// The tiny WordNet, in one file of which `from` is replaced by `to`.
test::WordNetTexts with(const std::string& file, const std::string& from, const std::string& to) {
  test::WordNetTexts texts = tinyWordNet();
  std::string& text = texts.at(file);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  return texts;
}

const WordNetSynset& synsetOf(const WordNet& wordNet, PartOfSpeech pos, std::uint32_t offset) {
  for (const WordNetSynset& synset : wordNet.synsets)
    if (synset.pos == pos && synset.offset == offset) return synset;
  throw std::runtime_error("no such synset");
}

const WordNetEntry& entryOf(const WordNet& wordNet, PartOfSpeech pos, const std::string& word) {
  for (const WordNetEntry& entry : wordNet.entries)
    if (entry.pos == pos && entry.word == word) return entry;
  throw std::runtime_error("no such entry");
}

TEST(ReadWordNet, TellsWordsWithTheirCountsRelationsAndGlosses) {
  const WordNet wordNet = readTexts(tinyWordNet());
  ASSERT_EQ(wordNet.synsets.size(), 15U);
  const WordNetSynset& dog = synsetOf(wordNet, PartOfSpeech::noun, 300);
  EXPECT_THAT(dog.words, ElementsAre("dog", "domestic dog", "Canis familiaris"));
  EXPECT_THAT(dog.tagCounts, ElementsAre(42U, 0U, 0U));
  EXPECT_EQ(dog.category, WordCategory::animal);
  EXPECT_THAT(dog.gloss, testing::StartsWith("an animal that barks; \"the dog"));
  ASSERT_EQ(dog.relations.size(), 1U);
  EXPECT_EQ(dog.relations[0].symbol, "@");
  EXPECT_EQ(wordNet.synsets[dog.relations[0].target].offset, 200U);

  const WordNetSynset& cook = synsetOf(wordNet, PartOfSpeech::verb, 100);
  ASSERT_EQ(cook.relations.size(), 1U) << "verb frames follow; they are no relations";
  EXPECT_EQ(cook.relations[0].pos, PartOfSpeech::noun);
  EXPECT_EQ(wordNet.synsets[cook.relations[0].target].words.front(), "stove");
}

TEST(ReadWordNet, KnowsSatellitesOfAdjectivesAndIrregularForms) {
  const WordNet wordNet = readTexts(tinyWordNet());
  const WordNetSynset& burning = synsetOf(wordNet, PartOfSpeech::adjective, 200);
  EXPECT_THAT(burning.words, ElementsAre("burning"));
  EXPECT_THAT(burning.tagCounts, ElementsAre(3U));
  std::vector<std::string> told;
  for (const WordNet::IrregularForm& irregular : wordNet.irregularForms)
    told.push_back(irregular.form + " of " + irregular.word);
  EXPECT_THAT(told, ElementsAre("knives of knife", "mice of mouse", "cooken of cook", "cooken of wash"));
}

TEST(ReadWordNet, RefusesMissingAndDamagedFiles) {
  for (const auto& [name, text] : tinyWordNet()) {
    test::WordNetTexts texts = tinyWordNet();
    texts.erase(name);
    EXPECT_THAT([&] { readTexts(texts); }, FailsWith(ErrorCode::fileUnreadable));
  }
  struct Damage {
    const char *file, *from, *to;
  };
  for (const auto& [file, from, to] : std::vector<Damage>{
           {"data.noun", "00000200 05", "000x0200 05"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n"},
           {"data.noun", "00000300 05 n 03", "00000300 zz n 03"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n 00"},
           {"data.noun", "00000300 05 n 03", "00000300 05 q 03"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n ffffffff"},
           {"data.noun", "00000300 05 n 03", "00000300 05 n fffffffff"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 4294967295 @ 00000200 n 0000 | an animal"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 -1 @ 00000200 n 0000 | an animal"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 001 @ 00000200 x 0000 | an animal"},
           {"data.noun", "0 001 @ 00000200 n 0000 | an animal", "0 001 @ 00000201 n 0000 | an animal"},
           {"data.noun", "00000400 05 n 01 mouse", "00000300 05 n 01 mouse"},
           {"data.verb", "00000100 30 v", "00000100 30"},
           {"data.adv", "02 r 01 quickly 0 000", "02 r 01 quickly"},
           {"index.noun", "mouse n 2 1 @ 2 1 00000400 00000500", "mouse n 2 1 @ 2 1 00000400"},
           {"index.noun", "mouse n 2 1 @ 2 1 00000400", "mouse n 2 1 @ 2 1 00000401"},
           {"index.noun", "mouse n 2 1", "mouse n 4000000000 1"},
           {"index.noun", "mouse n 2 1", "mouse n 2 4000000000"},
           {"index.verb", "wash v 1", "wash v one"},
           {"noun.exc", "mice mouse", "mice"},
           {"cntlist.rev", "dog%1:05:00:: 1 42", "dog%1:05:00:: 1"},
           {"cntlist.rev", "dog%1:05:00:: 1 42", "dog%1:05:00:: 1 many"}}) {
    const auto texts = with(file, from, to);
    EXPECT_THAT([&] { readTexts(texts); }, FailsWith(ErrorCode::malformedFile)) << to;
  }
}

TEST(FindWordNet, FollowsTheVariable) {
  const test::ScratchFolder folder;
  setenv("ESTANCIA_WORDNET", folder.path().c_str(), 1);
  EXPECT_EQ(findWordNet(), std::nullopt) << "an empty folder";
  test::writeWordNet(tinyWordNet(), folder.path());
  EXPECT_EQ(findWordNet(), folder.path());
  unsetenv("ESTANCIA_WORDNET");
}

TEST(InstalledWordNet, IsTheWholeOfVersionThree) {
  const std::optional<fs::path> folder = findWordNet();
  ASSERT_TRUE(folder) << "script/bootstrap installs wordnet-base";
  for (const fs::path& file : wordNetFiles(*folder)) EXPECT_TRUE(fs::is_regular_file(file)) << file;
  EXPECT_EQ(wordNetFiles(*folder).size(), 13U);
  const WordNet wordNet = readWordNet(*folder);
  EXPECT_EQ(wordNet.synsets.size(), 117659U);
  EXPECT_EQ(wordNet.entries.size(), 155287U);
  const WordNetSynset& dog = synsetOf(wordNet, PartOfSpeech::noun, 2084071);
  EXPECT_THAT(dog.words, ElementsAre("dog", "domestic dog", "Canis familiaris"));
  EXPECT_EQ(dog.tagCounts.front(), 42U);
  EXPECT_EQ(synsetOf(wordNet, PartOfSpeech::noun, 3063599).words.front(), "coffee mug");
  EXPECT_EQ(synsetOf(wordNet, PartOfSpeech::verb, 322847).pos, PartOfSpeech::verb);
  EXPECT_EQ(wordNet.synsets[entryOf(wordNet, PartOfSpeech::noun, "chair").synsets.front()].words.front(),
            "chair");
}

/// `edges` of pairs, each once, become edges of both directions.
WordGraph graphOf(std::uint32_t size, const Edges& edges, WordLink link = WordLink::related) {
  WordGraph graph;
  graph.offsets.resize(size);
  graph.categories.resize(size);
  graph.lexicon.firstSynset = {0, size, size, size, size};
  graph.nameStarts.assign(size + 1, 0);
  Edges both = edges;
  for (const auto& [pair, weight] : edges) both[{pair.second, pair.first}] = weight;
  graph.edgeStarts.assign(size + 1, 0);
  for (const auto& [pair, weight] : both) {
    ++graph.edgeStarts[pair.first + 1];
    graph.edgeTargets.push_back(pair.second);
    graph.edgeWeights.push_back(weight);
    const bool isGiven = edges.contains(pair);
    graph.edgeLinks.push_back(
        static_cast<std::uint8_t>(link == WordLink::kindOf && !isGiven ? WordLink::moreGeneral : link));
  }
  for (std::size_t i = 0; i < size; ++i) graph.edgeStarts[i + 1] += graph.edgeStarts[i];
  graph.sumDegrees();
  return graph;
}

Edges randomEdges(std::uint32_t size, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  Edges edges;
  while (edges.size() < count) {
    const auto a = static_cast<std::uint32_t>(random() % size),
               b = static_cast<std::uint32_t>(random() % size);
    if (a < b) edges[{a, b}] = 0.1F + static_cast<float>(random() % 100) / 50;
  }
  return edges;
}

/// Six steps of (0.9 × along an edge + 0.1 × anew), by the full matrix of transitions.
std::vector<double> slowWalk(const WordGraph& graph, const std::vector<Sense>& from) {
  const std::size_t n = graph.size();
  std::vector<std::vector<double>> weight(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i)
    for (std::uint32_t e = graph.edgeStarts[i]; e < graph.edgeStarts[i + 1]; ++e)
      weight[i][graph.edgeTargets[e]] = static_cast<double>(graph.edgeWeights[e]);
  std::vector<double> start(n, 0);
  for (const Sense& sense : from) start[sense.synset] += static_cast<double>(sense.probability);
  std::vector<double> at = start;
  for (int step = 0; step < 6; ++step) {
    std::vector<double> next(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      double degree = 0;
      for (std::size_t j = 0; j < n; ++j) degree += weight[i][j];
      for (std::size_t j = 0; j < n && degree > 0; ++j) next[j] += 0.9 * at[i] * weight[i][j] / degree;
    }
    for (std::size_t i = 0; i < n; ++i) at[i] = next[i] + 0.1 * start[i];
  }
  return at;
}

TEST(WordGraphWalk, IsThatOfTheFullMatrix) {
  // Few edges: few are reached, from which walkers spread; many: all are gathered for.
  for (const auto& [size, count] : {std::pair{40U, 30U}, {300U, 330U}, {300U, 6000U}, {3U, 3U}}) {
    const WordGraph graph = graphOf(size, randomEdges(size, count, size + count));
    for (const std::vector<Sense>& from :
         {std::vector<Sense>{{0, 1}}, std::vector<Sense>{{1, 0.5F}, {2, 0.3F}, {1, 0.2F}}}) {
      const std::vector<float> visits = graph.walk(from);
      const std::vector<double> expected = slowWalk(graph, from);
      double sum = 0;
      for (std::size_t i = 0; i < size; ++i) {
        ASSERT_NEAR(static_cast<double>(visits[i]), expected[i], 1e-5) << size << " synsets, synset " << i;
        sum += static_cast<double>(visits[i]);
      }
      EXPECT_LE(sum, 1 + 1e-5);
    }
  }
}

TEST(WordGraphHypernyms, AreAllAboveWithTheShortestWay) {
  const WordGraph graph =
      graphOf(5, {{{0, 1}, 1}, {{1, 2}, 1}, {{0, 3}, 1}, {{3, 4}, 1}, {{4, 2}, 1}}, WordLink::kindOf);
  EXPECT_THAT(graph.hypernyms(0),
              testing::UnorderedElementsAre(Pair(0, 0), Pair(1, 1), Pair(3, 1), Pair(2, 2), Pair(4, 2)));
  EXPECT_THAT(graph.hypernyms(2), ElementsAre(Pair(2, 0)));
}

/// What joins `a` and `b`, seen from `a`, with its weight.
std::pair<WordLink, float> linkOf(const WordGraph& graph, const char* a, const char* b) {
  const std::uint32_t from = graph.lexicon.senses(a).front().synset;
  const std::uint32_t to = graph.lexicon.senses(b).front().synset;
  for (std::uint32_t e = graph.edgeStarts[from]; e < graph.edgeStarts[from + 1]; ++e)
    if (graph.edgeTargets[e] == to) return {static_cast<WordLink>(graph.edgeLinks[e]), graph.edgeWeights[e]};
  return {WordLink::related, 0};
}

TEST(BuildWordGraph, JoinsRelationsAndDefinitionsBothWays) {
  const test::ScratchFolder folder;
  test::writeWordNet(test::tinyWordNet(), folder.path());
  const WordGraph graph = buildWordGraph(readWordNet(folder.path()));
  EXPECT_EQ(linkOf(graph, "dog", "animal").first, WordLink::kindOf);
  EXPECT_EQ(linkOf(graph, "animal", "dog").first, WordLink::moreGeneral);
  EXPECT_EQ(linkOf(graph, "room", "stove").first, WordLink::hasPart);
  EXPECT_EQ(linkOf(graph, "living room", "animal").first, WordLink::defines);
  EXPECT_EQ(linkOf(graph, "animal", "living room").first, WordLink::definedBy);
  EXPECT_EQ(linkOf(graph, "dog", "kitchen").second, 0) << "an example is no definition";
  EXPECT_GT(linkOf(graph, "knife", "kitchen").second, 0) << "its definition and its name";
  EXPECT_EQ(graph.pos(graph.lexicon.senses("cook").front().synset), PartOfSpeech::verb);
  EXPECT_EQ(graph.pos(graph.lexicon.senses("quickly").front().synset), PartOfSpeech::adverb);
}

TEST(WordGraph, WalksFromEachOfAnyNumberOfStarts) {
  const WordGraph graph = graphOf(100, randomEdges(100, 300, 5));
  for (const std::size_t count : {0, 1, 2, 3, 5, 8, 11}) {
    std::vector<std::vector<Sense>> starts;
    for (std::uint32_t i = 0; i < count; ++i) starts.push_back({{i, 0.25F}, {2 * i + 1, 0.75F}});
    const std::vector<std::vector<float>> walks = graph.walkEach(starts);
    ASSERT_EQ(walks.size(), count);
    for (std::size_t i = 0; i < count; ++i)
      EXPECT_THAT(walks[i], testing::Pointwise(testing::FloatNear(1e-6F), graph.walk(starts[i])))
          << i << " of " << count;
  }
}

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

TEST(WordGraphFile, IsRefusedWhenItIsOfAnotherWordNetOrVersionOrAWeightIsNone) {
  std::string bytes = packWordGraph(tinyGraph(), "a WordNet");
  EXPECT_THAT([&] { unpackWordGraph(bytes, "another", "words.graph"); },
              FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { unpackWordGraph("ESTWORDX" + bytes.substr(8), "a WordNet", "words.graph"); },
              FailsWith(ErrorCode::malformedFile));
  ++bytes[8];
  EXPECT_THAT([&] { unpackWordGraph(bytes, "a WordNet", "words.graph"); },
              FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { unpackWordGraph("", "a WordNet", "words.graph"); }, FailsWith(ErrorCode::truncatedFile));
  WordGraph graph = tinyGraph();
  for (const float weight : {0.0F, 1e30F, std::nanf("")})
    for (std::size_t behind = 1; behind <= 9; ++behind) {
      float& bad = graph.edgeWeights[graph.edgeWeights.size() - behind];
      const float good = std::exchange(bad, weight);
      EXPECT_THAT([&] { unpackWordGraph(packWordGraph(graph, ""), "", "words.graph"); },
                  FailsWith(ErrorCode::corruptFile));
      bad = good;
    }
}

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

TEST(WordGraphFile, CanBeUsedOrIsRefusedWhateverIsDamaged) {
  const std::string sound = packWordGraph(tinyGraph(), "");
  std::mt19937 random(41);
  int refused = 0;
  for (int round = 0; round < 4000; ++round) {
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
  EXPECT_GT(refused, 1000);
}

TEST(WordGraphFile, IsRefusedWhenItIsCutOrTooLong) {
  const std::string bytes = packWordGraph(tinyGraph(), "");
  for (std::size_t length = 0; length < bytes.size(); length += 3)
    ASSERT_THROW(unpackWordGraph(std::string_view(bytes).substr(0, length), "", "words.graph"), Error)
        << length << " bytes";
  EXPECT_THAT([&] { unpackWordGraph(bytes + '\0', "", "words.graph"); }, FailsWith(ErrorCode::corruptFile));
}

}  // namespace
}  // namespace estancia
