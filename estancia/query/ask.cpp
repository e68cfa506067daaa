// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/ask.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "estancia/core/error.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/map_file/places.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/words/name_search.hpp"

namespace estancia {
namespace {

Meaning getMeaning(const TopologicalMap& map, const std::string& words, WordGraphSource source) {
  Meaning meaning = findMeaning(map, words, source);
  if (!meaning.empty()) return meaning;
  constexpr std::size_t shown = 60;
  const std::string asked = words.size() > shown ? words.substr(0, shown) + "…" : words;
  const std::vector<std::string> near = findNearSpellings(map.vocabulary, words);
  if (near.empty())
    throw NoAnswerError(fmt::format("none of the map's {} labels matches \"{}\"; ask for another word{}",
                                    map.vocabulary.size(), asked, missingWordsHint(source)));
  throw NoAnswerError(fmt::format("none of the map's {} labels matches \"{}\"; did you mean \"{}\"?",
                                  map.vocabulary.size(), asked, fmt::join(near, "\" or \"")));
}

/// The rank of a label among all of a node's labels, from 1; equal labels in order of the vocabulary.
std::size_t rankOf(const Node& node, std::size_t label) {
  std::size_t rank = 1;
  for (std::size_t other = 0; other < node.mean.size(); ++other)
    if (node.mean[other] > node.mean[label] || (node.mean[other] == node.mean[label] && other < label))
      ++rank;
  return rank;
}

void lookForLabels(const Node& node, const std::vector<LabelMatch>& matches, PlaceAnswer& answer) {
  double most = -1;
  for (const LabelMatch& match : matches) {
    const double part = match.probability * static_cast<double>(node.mean[match.label]);
    answer.probability += part;
    if (part > most) most = part, answer.label = match.label;
  }
  answer.rank = rankOf(node, answer.label);
}

void lookForRooms(const Place& place, const std::vector<std::string>& rooms, std::size_t roomCount,
                  PlaceAnswer& answer) {
  answer.room = rooms.front();
  answer.rank = roomCount;  // where nothing was predicted
  for (std::size_t i = 0; i < place.predicted.size(); ++i) {
    const auto& [room, probability] = place.predicted[i];
    if (std::find(rooms.begin(), rooms.end(), room) == rooms.end()) continue;
    if (answer.probability == 0) answer.rank = i + 1, answer.room = room;
    answer.probability += probability;
  }
}

/// Names of the map's rooms: those that a classifier knows or the user has listed, else, by their names
/// alone, those that places surely are, as others need not be there.
std::vector<std::string> knownRooms(const TopologicalMap& map) {
  if (!map.predictions) return {};
  if (!map.predictions->areByName || map.predictions->areListed) return map.predictions->rooms;
  std::vector<std::string> rooms;
  for (const Place& place : placesOf(map))
    if (const RoomProbability* room = place.predictedRoom();
        room != nullptr && std::ranges::find(rooms, room->room) == rooms.end())
      rooms.push_back(room->room);
  return rooms;
}

/// The room that the words misspell, in which case `corrected` gets its name, or mean, or are a kind of.
std::vector<std::string> roomsInOtherWords(const std::vector<std::string>& rooms, const std::string& words,
                                           WordGraphSource source, std::string& corrected) {
  std::optional<NameMatch> match = findName(rooms, words, source);
  if (!match) match = findNameOfKind(rooms, words, source);
  if (!match) return {};
  if (match->isSpelling) corrected = rooms[match->name];
  return {rooms[match->name]};
}

}  // namespace

Meaning findMeaning(const TopologicalMap& map, const std::string& words, WordGraphSource source) {
  Meaning meaning;
  const std::vector<std::string> rooms = knownRooms(map);
  for (const std::string& room : rooms)
    if (sameWords(room, words)) meaning.rooms.push_back(room);
  if (!meaning.rooms.empty()) return meaning;
  if (!rooms.empty() && findLabels(map.vocabulary, words).empty()) {
    for (const std::size_t room : findLabels(Vocabulary(rooms), words)) meaning.rooms.push_back(rooms[room]);
    if (meaning.rooms.empty()) meaning.rooms = roomsInOtherWords(rooms, words, source, meaning.corrected);
  }
  if (!meaning.rooms.empty()) return meaning;
  LabelMatches found = findLabelMatches(map.vocabulary, words, source);
  meaning.matches = std::move(found.labels);
  meaning.corrected = std::move(found.corrected);
  for (const LabelMatch& match : meaning.matches) meaning.labels.push_back(match.label);
  return meaning;
}

std::vector<PlaceAnswer> placesThatHold(const Meaning& meaning, const TopologicalMap& map,
                                        std::size_t count) {
  if (map.nodes.empty())
    throw Error(ErrorCode::insufficientData, "the map has no places yet; map some images first");
  const std::vector<Place> places = meaning.rooms.empty() ? std::vector<Place>() : placesOf(map);
  std::vector<PlaceAnswer> answers;
  double sum = 0, images = 0;
  for (std::size_t i = 0; i < map.nodes.size(); ++i) {
    const Node& node = map.nodes[i];
    PlaceAnswer answer;
    answer.node = node.id;
    if (meaning.rooms.empty())
      lookForLabels(node, meaning.matches, answer);
    else
      lookForRooms(places[i], meaning.rooms, map.predictions->rooms.size(), answer);
    answer.probability = std::min(answer.probability, 1.0);
    answer.inTop5 = answer.rank <= 5;
    sum += answer.probability * static_cast<double>(node.frames);
    images += static_cast<double>(node.frames);
    answers.push_back(answer);
  }
  const double mean = sum / images;
  for (PlaceAnswer& answer : answers) answer.lift = mean > 0 ? answer.probability / mean : 0;
  std::sort(answers.begin(), answers.end(), [](const PlaceAnswer& a, const PlaceAnswer& b) {
    return a.probability != b.probability ? a.probability > b.probability
           : a.rank != b.rank             ? a.rank < b.rank
                                          : a.node < b.node;
  });
  if (answers.size() > count) answers.resize(count);
  return answers;
}

Answers ask(const TopologicalMap& map, const std::string& words, std::size_t count, WordGraphSource source) {
  Meaning meaning = getMeaning(map, words, source);
  std::vector<PlaceAnswer> places = placesThatHold(meaning, map, count);
  return {std::move(meaning), std::move(places)};
}

}  // namespace estancia
