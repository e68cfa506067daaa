// SPDX-License-Identifier: Apache-2.0
#include "scenes/scenes_statistics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

#include "estancia/files/csv.hpp"

namespace estancia::experiments {
namespace {

using Pair = ScenesResults::Pair;

std::size_t cellCount(const ScenesResults& results) {
  return results.descriptors.size() * results.classifiers.size();
}

const SceneAnswers& cellOf(const ScenesResults& results, std::size_t pair, std::size_t cell) {
  return results.cells[pair * cellCount(results) + cell];
}

std::vector<std::size_t> pairsThatTell(const ScenesResults& results) {
  std::vector<std::size_t> pairs;
  for (std::size_t p = 0; p < results.pairs.size(); ++p)
    if (results.tells(results.pairs[p])) pairs.push_back(p);
  return pairs;
}

/// A method's score is the share of right answers of its cells together, the mean of theirs.
template <class MethodOf>
MethodScores pooled(const SceneBlocks& blocks, std::size_t methods, MethodOf methodOf) {
  MethodScores scores{{}, blocks.names, {}};
  for (std::size_t b = 0; b < blocks.right.size(); ++b) {
    std::vector<std::size_t> right(methods);
    for (std::size_t c = 0; c < blocks.right[b].size(); ++c) right[methodOf(c)] += blocks.right[b][c];
    const std::size_t answers = blocks.answers[b] * (blocks.right[b].size() / methods);
    auto& values = scores.values.emplace_back();
    for (const std::size_t count : right)
      values.push_back(static_cast<double>(count) / static_cast<double>(answers));
  }
  return scores;
}

/// What a choice among cells needs to know of a pair.
struct AskedPair {
  std::vector<std::size_t> places;              // place of each run among those that are drawn
  std::vector<double> answers;                  // answers of each run
  std::vector<std::vector<std::size_t>> right;  // [cell][run]

  /// Share of right answers of each cell with the runs weighted by `weight`; none if all weights are 0.
  template <class Weight>
  std::vector<double> shares(Weight weight) const {
    double all = 0;
    for (std::size_t r = 0; r < places.size(); ++r) all += weight(places[r]) * answers[r];
    std::vector<double> found;
    if (all <= 0) return found;
    for (const auto& counts : right) {
      double sum = 0;
      for (std::size_t r = 0; r < places.size(); ++r)
        sum += weight(places[r]) * static_cast<double>(counts[r]);
      found.push_back(sum / all);
    }
    return found;
  }
};

}  // namespace

SceneBlocks blocksOf(const ScenesResults& results) {
  SceneBlocks blocks;
  if (results.pairs.size() >= minPairs) {
    for (std::size_t p = 0; p < results.pairs.size(); ++p) {
      blocks.names.push_back(fmt::format("{}→{}", results.pairs[p].train, results.pairs[p].test));
      const SceneTest& test = results.pairs[p].images;
      blocks.answers.push_back(test.rooms.size() * cellOf(results, p, 0).answers.size());
      auto& right = blocks.right.emplace_back();
      for (std::size_t c = 0; c < cellCount(results); ++c) {
        const auto counts = cellOf(results, p, c).rightInRuns(test);
        right.push_back(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
      }
    }
    return blocks;
  }
  blocks.runs = true;
  for (const std::size_t p : pairsThatTell(results)) {
    const Pair& pair = results.pairs[p];
    const std::size_t first = blocks.right.size();
    for (const std::string& run : pair.runs) {
      blocks.names.push_back(fmt::format("{}→{}: {}", pair.train, pair.test, run));
      blocks.right.emplace_back(cellCount(results));
      blocks.answers.push_back(0);
    }
    for (const int run : pair.images.runs)
      blocks.answers[first + static_cast<std::size_t>(run)] += cellOf(results, p, 0).answers.size();
    for (std::size_t c = 0; c < cellCount(results); ++c) {
      const auto counts = cellOf(results, p, c).rightInRuns(pair.images);
      for (std::size_t r = 0; r < counts.size(); ++r) blocks.right[first + r][c] = counts[r];
    }
  }
  return blocks;
}

MethodScores scoresOfCells(const ScenesResults& results, const SceneBlocks& blocks) {
  MethodScores scores = pooled(blocks, cellCount(results), [](std::size_t cell) { return cell; });
  for (const auto& descriptor : results.descriptors)
    for (const std::string& classifier : results.classifiers)
      scores.methods.push_back(fmt::format("{}/{}", descriptor.name, classifier));
  return scores;
}

MethodScores scoresOfDescriptors(const ScenesResults& results, const SceneBlocks& blocks) {
  const std::size_t classifiers = results.classifiers.size();
  MethodScores scores = pooled(blocks, results.descriptors.size(),
                               [classifiers](std::size_t cell) { return cell / classifiers; });
  for (const auto& descriptor : results.descriptors) scores.methods.push_back(descriptor.name);
  return scores;
}

MethodScores scoresOfClassifiers(const ScenesResults& results, const SceneBlocks& blocks) {
  const std::size_t classifiers = results.classifiers.size();
  MethodScores scores =
      pooled(blocks, classifiers, [classifiers](std::size_t cell) { return cell % classifiers; });
  scores.methods = results.classifiers;
  return scores;
}

std::string scoresCsv(const MethodScores& scores) {
  std::string text = "test";
  for (const std::string& method : scores.methods) text += "," + io::csvCell(method);
  for (std::size_t t = 0; t < scores.tests.size(); ++t)
    text += fmt::format("\n{},{}", io::csvCell(scores.tests[t]), fmt::join(scores.values[t], ","));
  return text + "\n";
}

std::vector<double> meanAccuracies(const ScenesResults& results, const std::vector<std::size_t>& cells) {
  std::vector<double> means;
  const auto pairs = pairsThatTell(results);
  for (const std::size_t cell : cells) {
    double sum = 0;
    for (const std::size_t p : pairs) sum += cellOf(results, p, cell).accuracy(results.pairs[p].images);
    means.push_back(sum / static_cast<double>(pairs.size()));
  }
  return means;
}

double accuracyOfChoice(const ScenesResults& results, const std::vector<std::size_t>& cells,
                        std::uint64_t seed) {
  constexpr int draws = 1000;
  constexpr double rounding = 1e-12;
  // A test that several pairs ask about has its runs drawn once for all of them.
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  std::vector<AskedPair> asked;
  for (const std::size_t p : pairsThatTell(results)) {
    const Pair& pair = results.pairs[p];
    AskedPair& one = asked.emplace_back();
    for (const std::string& run : pair.runs)
      one.places.push_back(places.emplace(std::pair{pair.test, run}, places.size()).first->second);
    one.answers.resize(one.places.size());
    for (const int run : pair.images.runs)
      one.answers[static_cast<std::size_t>(run)] += static_cast<double>(cellOf(results, p, 0).answers.size());
    for (const std::size_t cell : cells)
      one.right.push_back(cellOf(results, p, cell).rightInRuns(pair.images));
  }
  const auto means = meanAccuracies(results, cells);
  const double plain = *std::max_element(means.begin(), means.end());
  std::mt19937_64 random(seed);
  std::vector<double> sums(asked.size()), measured(asked.size());
  for (int draw = 0; draw < draws; ++draw) {
    std::vector<std::size_t> drawn(places.size());
    for (std::size_t r = 0; r < drawn.size(); ++r) ++drawn[random() % drawn.size()];
    std::vector<double> inside(cells.size());
    for (const AskedPair& pair : asked) {
      const auto shares = pair.shares([&](std::size_t place) { return static_cast<double>(drawn[place]); });
      for (std::size_t c = 0; c < shares.size(); ++c) inside[c] += shares[c];
    }
    const double best = *std::max_element(inside.begin(), inside.end()) - rounding;
    const auto chosen = static_cast<double>(
        std::count_if(inside.begin(), inside.end(), [&](double value) { return value >= best; }));
    for (std::size_t p = 0; p < asked.size(); ++p) {
      const auto shares = asked[p].shares([&](std::size_t place) { return drawn[place] == 0 ? 1.0 : 0.0; });
      if (shares.empty()) continue;
      for (std::size_t c = 0; c < shares.size(); ++c)
        if (inside[c] >= best) sums[p] += shares[c] / chosen;
      measured[p] += 1;
    }
  }
  double sum = 0;
  for (std::size_t p = 0; p < asked.size(); ++p) {
    if (measured[p] <= 0) return plain;  // all is one run
    sum += sums[p] / measured[p];
  }
  return std::min(plain, sum / static_cast<double>(asked.size()));
}

}  // namespace estancia::experiments
