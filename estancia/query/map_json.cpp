// SPDX-License-Identifier: Apache-2.0
#include "estancia/query/map_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/query/explain.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

Json numberOrNull(double value) {
  return std::isnan(value) ? Json(nullptr) : Json(value);
}

}  // namespace

Json toJson(const Meaning& meaning, const Vocabulary& vocabulary) {
  Json json{{"labels", Json::array()}, {"matches", Json::array()}};
  for (const std::size_t label : meaning.labels) json["labels"].push_back(vocabulary[label]);
  for (const LabelMatch& match : meaning.matches)
    json["matches"].push_back({{"label", vocabulary[match.label]},
                               {"probability", match.probability},
                               {"reason", match.reason.empty() ? Json(nullptr) : Json(match.reason)}});
  json["corrected"] = meaning.corrected.empty() ? Json(nullptr) : Json(meaning.corrected);
  json["rooms"] = meaning.rooms;
  return json;
}

Json toJson(const std::string& words, const Answers& answers, const TopologicalMap& map,
            const std::vector<Place>& places) {
  Json json{{"words", words}};
  json.update(toJson(answers, map.vocabulary));
  json["places"] = Json::array();
  for (const PlaceAnswer& answer : answers.places) {
    const Place& place = places.at(indexOf(map, answer.node));
    Json entry{
        {"node", answer.node}, {"probability", answer.probability}, {"lift", answer.lift}, {"label", nullptr},
        {"rank", answer.rank}, {"among_best_5", answer.inTop5},     {"room", place.room}};
    if (answer.room.empty()) entry["label"] = map.vocabulary[answer.label];
    if (const RoomProbability* predicted = place.predictedRoom()) {
      entry["predicted_room"] = predicted->room;
      entry["room_probability"] = predicted->probability;
    }
    json["places"].push_back(std::move(entry));
  }
  return json;
}

Json toJson(const Route& route) {
  return {{"from", route.nodes.front()},
          {"to", route.nodes.back()},
          {"nodes", route.nodes},
          {"cost", route.cost},
          {"unit", route.metric ? "m" : "transitions"}};
}

Json toJson(const std::string& words, const WordRoute& found, const TopologicalMap& map) {
  Json json = toJson(found.route);
  json["words"] = words;
  if (found.goal.room.empty())
    json["label"] = map.vocabulary[found.goal.label];
  else
    json["room"] = found.goal.room;
  json["probability"] = found.goal.probability;
  return json;
}

Json toJson(const std::string& image, const Localization& answer, const TopologicalMap& map) {
  Json json{{"image", image},
            {"node", answer.node},
            {"nearest_image", map.frames.at(answer.nearestImage).name},
            {"nearest_frame", map.frames.at(answer.nearestImage).number},
            {"distance", answer.distance},
            {"belief_node", answer.beliefNode},
            {"belief_image", map.frames.at(answer.beliefImage).name},
            {"belief_frame", map.frames.at(answer.beliefImage).number},
            {"confidence", answer.confidence},
            {"unmapped", answer.unmapped ? Json(*answer.unmapped) : Json()},
            {"unvisited", answer.unvisited ? Json(*answer.unvisited) : Json()}};
  if (answer.beliefZone) {
    json["belief_zone"] = *answer.beliefZone < 0 ? Json() : Json(*answer.beliefZone);
    json["zone_confidence"] = answer.zoneConfidence;
  }
  return json;
}

Json explanationJson(const TopologicalMap& map, std::size_t frame) {
  const std::vector<std::string> sentences = explain(map, frame);
  const Decision& decision = *std::ranges::find(map.decisions, frame, &Decision::frame);
  return {{"frame", map.frames[frame].name},
          {"number", map.frames[frame].number},
          {"decision", toString(decision.kind)},
          {"node", decision.node},
          {"node_now", map.frames[frame].node},
          {"current", decision.current},
          {"to_current", numberOrNull(decision.toCurrent)},
          {"other", decision.other},
          {"to_other", numberOrNull(decision.toOther)},
          {"tau_join", decision.tauJoin},
          {"tau_revisit", decision.tauRevisit},
          {"sentences", sentences}};
}

}  // namespace estancia
