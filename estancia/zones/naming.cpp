// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/naming.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "estancia/core/label_words.hpp"

namespace estancia {
namespace {

/// The first `count` different words: words with evidence, then likely ones.
std::vector<std::string> distinctiveWords(const Vocabulary& vocabulary, DescriptorView zone,
                                          DescriptorView run, const LabelConcepts& concepts,
                                          std::size_t count) {
  std::vector<std::string> words;
  std::set<std::size_t> told;
  for (TellingWord& word : tellingWords(vocabulary, concepts, zone, run, count)) {
    told.insert(word.labels.begin(), word.labels.end());
    words.push_back(std::move(word.name));
  }
  for (const std::size_t label : distinctiveLabels(zone, run, 2 * count)) {
    std::string word = shortLabel(vocabulary[label]);
    if (words.size() < count && !told.contains(label) && std::ranges::find(words, word) == words.end())
      words.push_back(std::move(word));
  }
  return words;
}

using Json = nlohmann::ordered_json;

Json zoneJson(const Zone& zone, const Zones& zones, const std::vector<float>& run, std::size_t count,
              const LabelConcepts& concepts) {
  std::vector<std::string> wordOf(zone.mean.size());
  for (const FamiliarWord& word : familiarWords(zones.vocabulary, concepts, zone.mean, zone.mean.size()))
    for (const std::size_t label : word.labels) wordOf[label] = word.name;
  Json words = Json::array();
  for (const std::size_t label : distinctiveLabels(zone.mean, run, count)) {
    const auto p = static_cast<double>(zone.mean[label]);
    words.push_back({{"label", zones.vocabulary[label]},
                     {"word", wordOf[label]},
                     {"p", p},
                     {"lift", p / static_cast<double>(run[label])}});
  }
  const double share = static_cast<double>(zone.images.size()) / static_cast<double>(zones.frames.size());
  Json json{{"id", zone.id},  {"name", zone.name}, {"images", zone.images.size()}, {"share", share},
            {"words", words}, {"room", nullptr},   {"position", nullptr}};
  if (!zone.room.empty()) {
    json["room"] = zone.room;
    json["room_share"] = zone.roomShare;
  }
  for (const auto& [room, probability] : zone.predicted)
    json["predicted_rooms"].push_back({{"room", room}, {"p", probability}});
  if (zone.extent) {
    json["position"] = zone.extent->center;
    json["spread"] = zone.extent->spread;
  }
  return json;
}

/// Zones that are taken for one room, in order of the largest.
struct PredictedRoom {
  std::string name;
  std::vector<int> zones;
  std::size_t images = 0;
  double probability = 0;   ///< mean over the images
  std::vector<float> mean;  ///< mean over the images
};

std::vector<PredictedRoom> predictedRooms(const Zones& zones) {
  std::vector<PredictedRoom> rooms;
  for (const Zone& zone : zones.zones) {
    if (zone.predicted.empty()) continue;
    const auto& [name, probability] = zone.predicted.front();
    auto room = std::ranges::find(rooms, name, &PredictedRoom::name);
    if (room == rooms.end())
      room = rooms.insert(rooms.end(), {name, {}, 0, 0, std::vector<float>(zone.mean.size(), 0)});
    room->zones.push_back(zone.id);
    room->images += zone.images.size();
    const double share = static_cast<double>(zone.images.size()) / static_cast<double>(room->images);
    room->probability += share * (probability - room->probability);
    for (std::size_t i = 0; i < zone.mean.size(); ++i)
      room->mean[i] += static_cast<float>(share) * (zone.mean[i] - room->mean[i]);
  }
  return rooms;
}

Json roomsJson(const Zones& zones, std::size_t words) {
  const std::vector<float> run = runMean(zones);
  Json json = Json::object();
  const auto add = [&](std::string name, std::size_t images, const std::vector<float>& mean,
                       std::size_t number) {
    if (json.contains(name)) name += fmt::format(" ({})", number);
    Json list = Json::object();
    for (const std::size_t label : distinctiveLabels(mean, run, words)) {
      const std::string word = shortLabel(zones.vocabulary[label]);
      const double known = list.value(word, 0.0);  // labels of several models may be one word
      list[word] = std::min(1.0, known + std::round(static_cast<double>(mean[label]) * 1e6) / 1e6);
    }
    json[name] = {{"images", images}, {"words", list}};
  };
  for (std::size_t i = 0; i < zones.rooms.size(); ++i)
    add(zones.rooms[i].name, zones.rooms[i].images, zones.rooms[i].mean, i);
  const std::vector<PredictedRoom> predicted =
      zones.rooms.empty() ? predictedRooms(zones) : std::vector<PredictedRoom>();
  for (const PredictedRoom& room : predicted) {
    add(room.name, room.images, room.mean, 0);
    json[room.name]["predicted"] = std::round(room.probability * 1e6) / 1e6;
    json[room.name]["zones"] = room.zones;
  }
  const bool isByClassifier = !zones.classifier.empty();
  for (std::size_t i = 0; zones.rooms.empty() && !isByClassifier && i < zones.zones.size(); ++i)
    if (zones.zones[i].predicted.empty())
      add(zones.zones[i].name, zones.zones[i].images.size(), zones.zones[i].mean, i);
  return json;
}

}  // namespace

std::vector<std::size_t> distinctiveLabels(DescriptorView zone, DescriptorView run, std::size_t count) {
  std::vector<float> contribution(zone.size());
  for (std::size_t i = 0; i < zone.size(); ++i)
    contribution[i] =
        static_cast<float>(tellingEvidence(static_cast<double>(zone[i]), static_cast<double>(run[i])));
  std::vector<std::size_t> labels = bestLabels(contribution, count);
  std::erase_if(labels, [&](std::size_t label) { return contribution[label] <= 0; });
  for (const std::size_t label : bestLabels(zone, count)) {
    const bool known = std::ranges::find(labels, label) != labels.end();
    if (labels.size() < count && !known && zone[label] > 0) labels.push_back(label);
  }
  return labels;
}

std::vector<std::string> nameZones(const Vocabulary& vocabulary, const std::vector<std::vector<float>>& means,
                                   DescriptorView run, const LabelConcepts& concepts) {
  std::vector<std::string> names;
  std::set<std::set<std::string>> taken;  // whatever their order
  for (const std::vector<float>& mean : means) {
    // Zones that still have the same name after twelve words are alike to people.
    const std::vector<std::string> words = distinctiveWords(vocabulary, mean, run, concepts, 12);
    // The thesis shows three words (Fig. 5.6).
    auto end = words.begin() + std::min<std::ptrdiff_t>(3, std::ssize(words));
    while (end != words.end() && taken.contains({words.begin(), end})) ++end;
    taken.emplace(words.begin(), end);
    names.push_back(words.empty() ? "no words" : fmt::format("{}", fmt::join(words.begin(), end, ", ")));
  }
  return names;
}

Json toJson(const Zones& zones, std::size_t words, const LabelConcepts& concepts) {
  Json json{{"model", zones.model}, {"distance", zones.distance},    {"linkage", zones.linkage},
            {"cut", zones.cut},     {"cut_reason", zones.cutReason}, {"zones", Json::array()}};
  const std::vector<float> run = runMean(zones);
  for (const Zone& zone : zones.zones) json["zones"].push_back(zoneJson(zone, zones, run, words, concepts));
  json["rooms"] = roomsJson(zones, 10);
  return json;
}

std::string toRoomsJson(const Zones& zones, std::size_t words) {
  return roomsJson(zones, words).dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace estancia
