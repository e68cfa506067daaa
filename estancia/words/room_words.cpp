// SPDX-License-Identifier: Apache-2.0
#include "estancia/words/room_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <span>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/words/label_senses.hpp"
#include "estancia/words/lexicon.hpp"

namespace estancia {
namespace {

/// Most artifacts have nothing to do with a room. Chosen on the training half of NYU Depth V2.
constexpr double minDeviations = 2;
/// Weight of all furnishings of a common room together, relative to its name.
constexpr double furnishingShare = 0.5;

/// Senses of a name's words, one after the other.
std::vector<std::vector<Sense>> sensesOfName(const WordGraph& graph, const std::string& name) {
  const std::string text = lexicalForm(name);
  std::vector<std::vector<Sense>> found;
  for (const std::string& word : graph.lexicon.knows(text) ? std::vector{text} : graph.lexicon.terms(text))
    if (std::vector<Sense> senses = graph.lexicon.senses(word); !senses.empty())
      found.push_back(std::move(senses));
  return found;
}

const std::vector<CommonRoom>& commonRoomTable() {
  static const std::vector<CommonRoom> rooms = {
      {"kitchen", {"stove", "refrigerator", "sink", "oven", "microwave", "dishwasher"}},
      {"living room", {"sofa", "television", "armchair", "fireplace", "coffee table"}},
      {"dining room", {"dining table", "chair", "chandelier"}},
      {"bedroom", {"bed", "pillow", "wardrobe", "dresser"}},
      {"bathroom", {"toilet", "bathtub", "washbasin", "shower", "towel", "mirror"}},
      {"corridor", {"door", "doormat"}},
      {"study", {"desk", "bookcase", "computer"}},
      {"office", {"desk", "computer", "printer", "swivel chair"}},
      {"nursery", {"crib", "cradle", "toy"}},
      {"laundry", {"washing machine", "iron", "clothes dryer"}},
      {"closet", {"clothes hanger", "clothes"}},
      {"staircase", {"stair", "banister"}},
      {"garage", {"car", "bicycle", "toolbox"}},
      {"balcony", {"railing", "flowerpot"}},
      {"garden", {"lawn", "flower", "lawn mower"}},
      {"library", {"bookcase", "book"}},
      {"classroom", {"blackboard", "desk", "chair"}},
      {"laboratory", {"beaker", "microscope", "test tube"}},
      {"workshop", {"workbench", "hammer", "drill"}},
      {"shop", {"counter", "shelf", "shopping cart"}},
      {"restaurant", {"menu", "dining table", "waiter"}},
      // Outdoors, by name alone: a robot that leaves the house is not to be taken for one in a garage.
      {"street", {}},
      {"park", {}},
      {"forest", {}},
      {"field", {}},
      {"beach", {}},
      {"mountain", {}},
  };
  return rooms;
}

/// Evidence of each label for a name, a value ≥ 0 a label; `walks` from the name's words.
std::vector<double> labelWeights(const WordGraph& graph, const std::vector<LabelSense>& senses,
                                 std::span<const std::vector<float>> walks) {
  const auto liftOf = [&](std::uint32_t synset) {
    double sum = 0;
    for (const std::vector<float>& visits : walks) sum += graph.lift(visits, synset);
    return sum / static_cast<double>(walks.size());
  };
  double sum = 0, squares = 0, count = 0;
  for (std::uint32_t synset = graph.lexicon.firstSynset[0]; synset < graph.lexicon.firstSynset[1]; ++synset) {
    if (graph.category(synset) != WordCategory::artifact) continue;
    const double lift = liftOf(synset);
    sum += lift;
    squares += lift * lift;
    ++count;
  }
  const double mean = sum / count, deviation = std::sqrt(std::max(squares / count - mean * mean, 1e-9));
  std::vector<double> weights;
  for (const LabelSense& label : senses) {
    double excess = 0;
    for (const Sense& sense : label.senses)
      excess += static_cast<double>(sense.probability) *
                std::max(0.0, (liftOf(sense.synset) - mean) / deviation - minDeviations);
    weights.push_back(excess * excess);
  }
  return weights;
}

[[noreturn]] void failUnknownRoom(const WordGraph& graph, const std::string& name) {
  const std::string near = correctSpelling(graph.lexicon, {}, lexicalForm(name));
  fail(ErrorCode::unknownName, "WordNet has no word for the room \"{}\"; {}", name,
       near.empty() ? "give it an English name" : fmt::format("is it \"{}\"?", near));
}

/// labelWeights() of each name, by the name.
std::map<std::string, std::vector<double>> labelWeightsOf(const WordGraph& graph,
                                                          const Vocabulary& vocabulary,
                                                          const std::set<std::string>& names) {
  std::vector<std::vector<Sense>> starts;  // senses of all names' words
  std::map<std::string, std::pair<std::size_t, std::size_t>> words;
  for (const std::string& name : names) {
    std::vector<std::vector<Sense>> own = sensesOfName(graph, name);
    if (own.empty()) failUnknownRoom(graph, name);
    words[name] = {starts.size(), own.size()};
    std::ranges::move(own, std::back_inserter(starts));
  }
  const std::vector<std::vector<float>> walks = graph.walkEach(starts);
  const std::vector<LabelSense> senses = findLabelSenses(graph, vocabulary);
  std::map<std::string, std::vector<double>> weights;
  for (const auto& [name, range] : words)
    weights[name] = labelWeights(graph, senses, std::span(walks).subspan(range.first, range.second));
  return weights;
}

}  // namespace

const std::vector<std::string>& commonRooms() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const CommonRoom& room : commonRoomTable()) list.push_back(room.name);
    return list;
  }();
  return names;
}

const CommonRoom* findCommonRoom(std::string_view words) {
  for (const CommonRoom& common : commonRoomTable())
    if (sameWords(common.name, words)) return &common;
  return nullptr;
}

const CommonRoom* findCommonRoom(const WordGraph& graph, std::string_view words) {
  if (const CommonRoom* named = findCommonRoom(words)) return named;
  const std::vector<std::uint32_t> asked = graph.lexicon.usualNouns(words);
  const CommonRoom* meant = nullptr;
  for (const CommonRoom& common : commonRoomTable()) {
    const std::vector<std::uint32_t> own = graph.lexicon.usualNouns(common.name);
    if (std::ranges::find_first_of(asked, own) == asked.end()) continue;
    if (meant != nullptr) return nullptr;
    meant = &common;
  }
  return meant;
}

std::vector<std::string> listedRooms(const std::vector<std::string>& names) {
  std::vector<std::string> rooms;
  for (const std::string& name : names) {
    const std::size_t from = name.find_first_not_of(" \t"), to = name.find_last_not_of(" \t");
    std::string room = from == std::string::npos ? "" : name.substr(from, to - from + 1);
    if (splitText(room).empty() || printable(room) != room)
      fail(ErrorCode::invalidOption,
           "\"{}\" is no name of a room; list names, separated by commas: kitchen,bedroom", name);
    if (std::ranges::none_of(rooms, [&](const std::string& other) { return sameWords(other, room); }))
      rooms.push_back(std::move(room));
  }
  return rooms;
}

bool knowsRooms(const WordGraph& graph, const std::vector<std::string>& rooms) {
  return std::ranges::all_of(rooms,
                             [&](const std::string& room) { return !sensesOfName(graph, room).empty(); });
}

std::vector<std::vector<float>> roomLabelWeights(const WordGraph& graph, const Vocabulary& vocabulary,
                                                 const std::vector<std::string>& rooms) {
  std::set<std::string> names(rooms.begin(), rooms.end());  // rooms share furnishings
  for (const std::string& room : rooms)
    if (const CommonRoom* common = findCommonRoom(graph, room))
      names.insert(common->furnishings.begin(), common->furnishings.end());
  const auto weightsOf = labelWeightsOf(graph, vocabulary, names);
  std::vector<std::vector<float>> weights;
  for (const std::string& room : rooms) {
    std::vector<double> sum = weightsOf.at(room);
    if (const CommonRoom* common = findCommonRoom(graph, room)) {
      const double share = furnishingShare / static_cast<double>(common->furnishings.size());
      for (const std::string& thing : common->furnishings)
        for (std::size_t label = 0; label < sum.size(); ++label)
          sum[label] += share * weightsOf.at(thing)[label];
    }
    weights.emplace_back(sum.begin(), sum.end());
  }
  return weights;
}

}  // namespace estancia
