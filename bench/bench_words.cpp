// Words: reading the word graph, walks from one to eight words, searches of one to four words, rooms' words;
// words that are misspelled, and ten thousand bytes of words or of none.
//   bench_words LABELS [options of Google Benchmark]
//                           LABELS is a label file, as that of a model with ImageNet's labels
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "estancia/core/vocabulary.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/room_words.hpp"
#include "estancia/words/word_files.hpp"

namespace {

using namespace estancia;

const std::vector<std::string> asked{"coffee", "kitchen knife", "something warm to wear",
                                     "a big soft chair to sit on"};

void loadGraph(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(loadInstalledWords());
}

void walk(benchmark::State& state, const WordGraph& graph) {
  const std::vector<std::string> words{"coffee", "knife", "wear", "chair", "sofa", "music", "door", "water"};
  std::vector<std::vector<Sense>> starts;
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.range(0)); ++i)
    starts.push_back(graph.lexicon.senses(words[i]));
  for (auto _ : state) benchmark::DoNotOptimize(graph.walkEach(starts));
  state.counters["edges"] = static_cast<double>(graph.edgeTargets.size());
}

void search(benchmark::State& state, const LabelSearch& labels) {
  const std::string& words = asked[static_cast<std::size_t>(state.range(0))];
  state.SetLabel(words);
  for (auto _ : state) benchmark::DoNotOptimize(labels.search(words));
}

void correct(benchmark::State& state, const WordGraph& graph) {
  for (auto _ : state)
    for (const char* word : {"refridgerator", "xyzzyxyzzy", "umbrela", "cmputer"})
      benchmark::DoNotOptimize(correctSpelling(graph.lexicon, {}, word));
}

/// `words` again and again.
std::string longText(const std::string& words) {
  std::string text;
  while (text.size() < 10000) text += words;
  return text;
}

void takeTerms(benchmark::State& state, const WordGraph& graph) {
  const std::string text = longText("living room of a dog ");
  for (auto _ : state) benchmark::DoNotOptimize(graph.lexicon.terms(text));
}

void searchGarbage(benchmark::State& state, const LabelSearch& labels) {
  const std::string text = longText("qzxwa qzxwb qzxwc qzxwd qzxwe qzxwf qzxwg qzxwh ");
  for (auto _ : state) benchmark::DoNotOptimize(labels.search(text));
}

void prepareSearch(benchmark::State& state, const WordGraph& graph, const Vocabulary& vocabulary) {
  for (auto _ : state) benchmark::DoNotOptimize(LabelSearch(vocabulary, &graph));
}

void weighRooms(benchmark::State& state, const WordGraph& graph, const Vocabulary& vocabulary) {
  for (auto _ : state) benchmark::DoNotOptimize(roomLabelWeights(graph, vocabulary, commonRooms()));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) return std::fputs("usage: bench_words LABELS [--benchmark_…]\n", stderr), 2;
  const Vocabulary vocabulary = readVocabulary(argv[1]);
  const WordGraph* graph = installedWordGraph();
  if (graph == nullptr) return std::fprintf(stderr, "%s\n", wordNetHint().c_str()), 2;
  const LabelSearch labels(vocabulary, graph);
  constexpr auto unit = benchmark::kMillisecond;
  benchmark::RegisterBenchmark("load", loadGraph)->Unit(unit);
  benchmark::RegisterBenchmark("walk", walk, *graph)->DenseRange(1, 4)->Arg(8)->Unit(unit);
  benchmark::RegisterBenchmark("prepare", prepareSearch, *graph, vocabulary)->Unit(unit);
  benchmark::RegisterBenchmark("search", search, labels)->DenseRange(0, 3)->Unit(unit);
  benchmark::RegisterBenchmark("search: garbage", searchGarbage, labels)->Unit(unit);
  benchmark::RegisterBenchmark("spelling: four words", correct, *graph)->Unit(unit);
  benchmark::RegisterBenchmark("terms of 10 kB", takeTerms, *graph)->Unit(unit);
  benchmark::RegisterBenchmark("rooms", weighRooms, *graph, vocabulary)->Unit(unit);
  argv[1] = argv[0];
  benchmark::Initialize(&--argc, ++argv);
  benchmark::RunSpecifiedBenchmarks();
} catch (const std::exception& e) {
  return std::fprintf(stderr, "error: %s\n", e.what()), 2;
}
