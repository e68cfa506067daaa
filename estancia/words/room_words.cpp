// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/room_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/words/label_senses.hpp"

namespace estancia {
namespace {

/// Most artifacts have nothing to do with a room. Chosen on the training half of NYU Depth V2.
constexpr double leastDeviations = 2;

/// Log lifts of all synsets from what a name means.
class NameLifts {
 public:
  NameLifts(const WordGraph& graph, const std::string& name) : graph_(graph) {
    const std::string text = lexicalForm(name);
    for (const std::string& word : graph.lexicon.knows(text) ? std::vector{text} : graph.lexicon.terms(text))
      if (const std::vector<Sense> senses = graph.lexicon.senses(word); !senses.empty())
        visits_.push_back(graph.walk(senses));
    if (visits_.empty())
      throw Error(
          ErrorCode::unknownName,
          fmt::format("WordNet has no word for the room \"{}\"; give it an English name", printable(name)));
  }

  double of(std::uint32_t synset) const {
    double sum = 0;
    for (const std::vector<float>& visits : visits_) sum += graph_.lift(visits, synset);
    return sum / static_cast<double>(visits_.size());
  }

 private:
  const WordGraph& graph_;
  std::vector<std::vector<float>> visits_;
};

}  // namespace

const std::vector<std::string>& commonRooms() {
  static const std::vector<std::string> rooms = {
      "kitchen", "living room", "dining room", "bedroom",    "bathroom",  "corridor", "study",
      "office",  "nursery",     "laundry",     "closet",     "staircase", "garage",   "balcony",
      "garden",  "library",     "classroom",   "laboratory", "workshop",  "shop",     "restaurant"};
  return rooms;
}

std::vector<std::vector<float>> roomLabelWeights(const WordGraph& graph, const Vocabulary& vocabulary,
                                                 const std::vector<std::string>& rooms) {
  const std::vector<LabelSense> senses = findLabelSenses(graph, vocabulary);
  std::vector<std::vector<float>> weights;
  for (const std::string& room : rooms) {
    const NameLifts lifts(graph, room);
    double sum = 0, squares = 0, count = 0;
    for (std::uint32_t synset = graph.lexicon.firstSynset[0]; synset < graph.lexicon.firstSynset[1];
         ++synset) {
      if (graph.category(synset) != WordCategory::artifact) continue;
      const double lift = lifts.of(synset);
      sum += lift;
      squares += lift * lift;
      ++count;
    }
    const double mean = sum / count, deviation = std::sqrt(std::max(squares / count - mean * mean, 1e-9));
    std::vector<float>& row = weights.emplace_back(vocabulary.size(), 0.0F);
    for (std::size_t label = 0; label < row.size(); ++label) {
      double excess = 0;
      for (const Sense& sense : senses[label].senses)
        excess += static_cast<double>(sense.probability) *
                  std::max(0.0, (lifts.of(sense.synset) - mean) / deviation - leastDeviations);
      row[label] = static_cast<float>(excess * excess);
    }
  }
  return weights;
}

}  // namespace estancia
