// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_query/ask_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <unordered_map>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/name_search.hpp"
#include "estancia/world_file/area_names.hpp"

namespace estancia {
namespace {

constexpr std::size_t bestWords = 5;  // see PlaceAnswer::inTop5

using LabelWeights = std::unordered_map<std::string_view, double>;  // how probably it is meant

void lookForLabels(const WorldObject& object, const LabelWeights& labels, ObjectAnswer& answer) {
  for (std::size_t i = 0; i < object.words.size(); ++i) {
    const auto meant = labels.find(object.words[i].label);
    if (meant == labels.end()) continue;
    if (answer.rank == 0) answer.rank = i + 1, answer.label = object.words[i].label;
    answer.probability += meant->second * static_cast<double>(object.words[i].probability);
  }
  answer.probability = answer.isNamed ? 1 : std::min(answer.probability, 1.0);
  if (answer.isKnown) answer.probability = std::max(answer.probability, object.known->confidence);
  if (answer.isShaped)
    answer.probability =
        std::max(answer.probability, static_cast<double>(object.shapeClasses.front().probability));
}

bool comesBefore(const ObjectAnswer& a, const ObjectAnswer& b) {
  return a.isNamed != b.isNamed           ? a.isNamed
         : a.isKnown != b.isKnown         ? a.isKnown
         : a.probability != b.probability ? a.probability > b.probability
         : a.rank != b.rank               ? a.rank < b.rank
                                          : a.object < b.object;
}

std::vector<ObjectAnswer> askObjects(const WorldMap& world, const WorldMeaning& meaning, std::size_t count) {
  LabelWeights labels;
  for (const LabelMatch& match : meaning.matches)
    labels.emplace(world.places.vocabulary[match.label], match.probability);
  std::vector<ObjectAnswer> answers;
  double sum = 0;
  for (const WorldObject& object : world.objects) {
    ObjectAnswer answer{
        .object = object.id,
        .isNamed = std::ranges::find(meaning.namedObjects, object.id) != meaning.namedObjects.end(),
        .isKnown = std::ranges::find(meaning.knownObjects, object.id) != meaning.knownObjects.end(),
        .isShaped = std::ranges::find(meaning.shapedObjects, object.id) != meaning.shapedObjects.end()};
    lookForLabels(object, labels, answer);
    sum += answer.probability;
    answers.push_back(std::move(answer));
  }
  const double mean = answers.empty() ? 0 : sum / static_cast<double>(answers.size());
  for (ObjectAnswer& answer : answers) answer.lift = mean > 0 ? answer.probability / mean : 0;
  std::erase_if(answers, [](const ObjectAnswer& answer) {
    return !answer.isLikely() && (answer.rank == 0 || answer.rank > bestWords || answer.lift < 1);
  });
  std::ranges::sort(answers, comesBefore);
  if (answers.size() > count) answers.resize(count);
  return answers;
}

/// The areas whose given names the words misspell or mean, unless labels hold the words.
std::vector<int> areasInOtherWords(const WorldMap& world, const std::string& words, WordGraphSource source) {
  std::set<std::string> given;
  for (const WorldArea& area : world.areas)
    if (!area.givenName.empty()) given.insert(area.givenName);
  const std::vector<std::string> names(given.begin(), given.end());
  if (names.empty() || !findLabels(world.places.vocabulary, words).empty()) return {};
  const auto match = findName(names, words, source);
  return match ? areasNamed(world, names[match->name]) : std::vector<int>();
}

}  // namespace

WorldMeaning findMeaning(const WorldMap& world, const std::string& words, WordGraphSource source) {
  WorldMeaning meaning{findMeaning(world.places, words, source)};
  meaning.areas = areasNamed(world, words);
  if (meaning.areas.empty() && meaning.rooms.size() == 1) meaning.areas = areasNamed(world, meaning.rooms[0]);
  if (meaning.areas.empty() && !meaning.corrected.empty())
    meaning.areas = areasNamed(world, meaning.corrected);
  meaning.isWholeName = !meaning.areas.empty();
  if (!meaning.isWholeName) meaning.areas = areasNamedPartly(world, words);
  if (meaning.areas.empty() && meaning.rooms.empty()) {
    meaning.areas = areasInOtherWords(world, words, source);
    meaning.isWholeName = !meaning.areas.empty();
  }
  for (const WorldObject& object : world.objects) {
    if (sameWords(object.givenName, words)) meaning.namedObjects.push_back(object.id);
    if (object.known && sameWords(object.known->name, words)) meaning.knownObjects.push_back(object.id);
    if (const std::string* name = object.shapeClass(); name != nullptr && sameWords(*name, words))
      meaning.shapedObjects.push_back(object.id);
  }
  return meaning;
}

WorldAnswers askWorld(const WorldMap& world, const std::string& words, std::size_t places,
                      std::size_t objects, WordGraphSource source) {
  WorldAnswers answers{findMeaning(world, words, source)};
  if (answers.empty()) {
    const std::vector<std::string> near = findNearNames(world, words);
    throw NoAnswerError(
        fmt::format("nothing in the map is called \"{}\", and none of its {} labels means it; {}{}",
                    printable(words), world.places.vocabulary.size(),
                    near.empty() ? "ask for another word"
                                 : fmt::format("did you mean \"{}\"?", fmt::join(near, "\" or \"")),
                    missingWordsHint(source)));
  }
  answers.objects = askObjects(world, answers, objects);
  if (!answers.Meaning::empty()) answers.places = placesThatHold(answers, world.places, places);
  return answers;
}

std::vector<std::string> findNearNames(const WorldMap& world, const std::string& words, std::size_t count) {
  std::set<std::string> given;
  for (const WorldArea& area : world.areas) {
    given.insert(area.givenName);
    given.insert(area.roomName);
  }
  for (const WorldObject& object : world.objects) {
    given.insert(object.givenName);
    if (object.known) given.insert(object.known->name);
    if (const std::string* name = object.shapeClass()) given.insert(*name);
  }
  given.erase("");
  std::vector<std::string> near;
  if (!given.empty())
    near = findNearSpellings(Vocabulary(std::vector<std::string>(given.begin(), given.end())), words, count);
  for (std::string& word : findNearSpellings(world.places.vocabulary, words, count))
    if (near.size() < count && std::ranges::find(near, word) == near.end()) near.push_back(std::move(word));
  return near;
}

std::vector<int> areasOfNodes(const WorldMap& world) {
  const TopologicalMap& map = world.places;
  std::vector<std::map<int, std::size_t>> frames(map.nodes.size());
  for (std::size_t i = 0; i < map.frames.size() && i < world.areaOfFrame.size(); ++i)
    if (const std::size_t node = indexOf(map, map.frames[i].node);
        node < frames.size() && world.areaOfFrame[i] >= 0)
      ++frames[node][world.areaOfFrame[i]];
  std::vector<int> areas;
  for (const std::map<int, std::size_t>& counts : frames) {
    const auto most = std::ranges::max_element(counts, {}, [](const auto& count) { return count.second; });
    areas.push_back(most == counts.end() ? -1 : most->first);
  }
  return areas;
}

}  // namespace estancia
