#include "estancia/topology/ask.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"

namespace estancia {
namespace {

std::vector<std::size_t> getLabels(const Vocabulary& vocabulary, const std::string& words) {
  std::vector<std::size_t> labels = findLabels(vocabulary, words);
  if (!labels.empty()) return labels;
  constexpr std::size_t shown = 60;
  const std::string asked = words.size() > shown ? words.substr(0, shown) + "…" : words;
  const std::vector<std::string> near = findNearSpellings(vocabulary, words);
  if (near.empty())
    throw NoAnswerError(fmt::format("none of the map's {} labels matches \"{}\"; ask for another word",
                                    vocabulary.size(), asked));
  throw NoAnswerError(fmt::format("none of the map's {} labels matches \"{}\"; did you mean \"{}\"?",
                                  vocabulary.size(), asked, fmt::join(near, "\" or \"")));
}

/// The rank of a label among all of a node's labels, from 1; equal labels in order of the vocabulary.
std::size_t rankOf(const Node& node, std::size_t label) {
  std::size_t rank = 1;
  for (std::size_t other = 0; other < node.mean.size(); ++other)
    if (node.mean[other] > node.mean[label] || (node.mean[other] == node.mean[label] && other < label))
      ++rank;
  return rank;
}

}  // namespace

Answers ask(const TopologicalMap& map, const std::string& words, std::size_t count) {
  Answers answers{getLabels(map.vocabulary, words), {}};
  if (map.nodes.empty()) throw Error("the map has no places yet; map some images first");
  double sum = 0, images = 0;
  for (const Node& node : map.nodes) {
    PlaceAnswer answer;
    answer.node = node.id;
    answer.label = answers.labels.front();
    for (const std::size_t label : answers.labels) {
      answer.probability += static_cast<double>(node.mean[label]);
      if (node.mean[label] > node.mean[answer.label]) answer.label = label;
    }
    answer.probability = std::min(answer.probability, 1.0);
    answer.rank = rankOf(node, answer.label);
    answer.amongBest5 = answer.rank <= 5;
    sum += answer.probability * static_cast<double>(node.frames);
    images += static_cast<double>(node.frames);
    answers.places.push_back(answer);
  }
  const double mean = sum / images;
  for (PlaceAnswer& answer : answers.places) answer.lift = mean > 0 ? answer.probability / mean : 0;
  std::sort(answers.places.begin(), answers.places.end(), [](const PlaceAnswer& a, const PlaceAnswer& b) {
    return a.probability != b.probability ? a.probability > b.probability
           : a.rank != b.rank             ? a.rank < b.rank
                                          : a.node < b.node;
  });
  if (answers.places.size() > count) answers.places.resize(count);
  return answers;
}

}  // namespace estancia
