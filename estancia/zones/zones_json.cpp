#include "estancia/zones/zones_json.hpp"

#include <string>
#include <vector>

#include "estancia/zones/naming.hpp"
#include "estancia/zones/rooms.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

Json zoneJson(const Zone& zone, const Zones& zones, const std::vector<float>& run, std::size_t count) {
  Json words = Json::array();
  for (const std::size_t label : distinctiveLabels(zone.mean, run, count)) {
    const auto p = static_cast<double>(zone.mean[label]);
    words.push_back(
        {{"label", zones.vocabulary[label]}, {"p", p}, {"lift", p / static_cast<double>(run[label])}});
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

}  // namespace

Json toJson(const Zones& zones, std::size_t words) {
  Json json{{"model", zones.model}, {"distance", zones.distance},    {"linkage", zones.linkage},
            {"cut", zones.cut},     {"cut_reason", zones.cutReason}, {"zones", Json::array()}};
  const std::vector<float> run = runMean(zones);
  for (const Zone& zone : zones.zones) json["zones"].push_back(zoneJson(zone, zones, run, words));
  json["rooms"] = Json::parse(toRoomsJson(zones));
  return json;
}

}  // namespace estancia
