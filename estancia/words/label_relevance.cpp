// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/label_relevance.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

// Logistic regression of "a person accepts the label" on the even queries of
// lab/experiments/words/queries.csv: a constant, the share of the query's meanings that the label is a kind
// of, its purpose squared, its log lift, and how far that is below the best label's. The version of files of
// associations (word_files.cpp) goes up with all that is here.
constexpr double bias = -2.36, kindWeight = 3.1, purposeWeight = 4, liftWeight = 0.72, gapWeight = 0.61;
/// Min relevance of a hyponym, however weak its other relations: a rocking chair is a chair, a chair a seat.
constexpr double kindFloor = 0.8;
constexpr double maxLift = 15, maxGap = 10;
/// A hypernym one step further away counts a little less.
constexpr double stepDecay = 0.95;

}  // namespace

double labelRelevance(const LabelEvidence& evidence) {
  const double logit = bias + kindWeight * evidence.kind +
                       purposeWeight * evidence.purpose * evidence.purpose + liftWeight * evidence.lift +
                       gapWeight * std::max(evidence.lift - evidence.bestLift, -maxGap);
  return std::max(1 / (1 + std::exp(-logit)), kindFloor * evidence.kind * evidence.kind);
}

double liftFor(double probability) {
  return (std::log(probability / (1 - probability)) - bias) / liftWeight;
}

double usedLift(double lift) {
  return std::clamp(lift, minUsedLift, maxLift);
}

double kindShare(float senseProbability, int distance) {
  return std::sqrt(static_cast<double>(senseProbability)) * hypernymDecay(distance);
}

double hypernymDecay(int distance) {
  return std::pow(stepDecay, distance);
}

double inheritedShare(std::span<const float> shares,
                      std::span<const std::pair<std::uint32_t, int>> hypernyms) {
  double best = 0;
  for (const auto& [above, distance] : hypernyms)
    best = std::max(best, static_cast<double>(shares[above]) * hypernymDecay(distance));
  return best;
}

double kindShare(std::span<const Sense> senses, std::span<const std::pair<std::uint32_t, int>> hypernyms) {
  double share = 0;
  for (const auto& [above, distance] : hypernyms)
    for (const Sense& sense : senses)
      if (sense.synset == above) share = std::max(share, kindShare(sense.probability, distance));
  return share;
}

std::vector<Sense> furnishingSenses(const WordGraph& graph, const std::string& word) {
  std::vector<Sense> senses = graph.lexicon.senses(word);
  std::erase_if(senses,
                [&](const Sense& sense) { return graph.category(sense.synset) != WordCategory::artifact; });
  float sum = 0;
  for (const Sense& sense : senses) sum += sense.probability;
  for (Sense& sense : senses) sense.probability /= sum;
  return senses;
}

}  // namespace estancia
