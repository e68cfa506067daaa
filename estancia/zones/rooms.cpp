#include "estancia/zones/rooms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/label_words.hpp"
#include "estancia/zones/naming.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string toRoomsJson(const Zones& zones, std::size_t words) {
  const std::vector<float> run = runMean(zones);
  Json json = Json::object();
  const auto add = [&](std::string name, std::size_t images, const std::vector<float>& mean,
                       std::size_t number) {
    if (json.contains(name)) name += fmt::format(" ({})", number);
    Json list = Json::object();
    for (const std::size_t label : tellingLabels(mean, run, words)) {
      const std::string word = shortLabel(zones.vocabulary[label]);
      const double known = list.value(word, 0.0);  // labels of several models may be one word
      list[word] = std::min(1.0, known + std::round(static_cast<double>(mean[label]) * 1e6) / 1e6);
    }
    json[name] = {{"images", images}, {"words", list}};
  };
  for (std::size_t i = 0; i < zones.rooms.size(); ++i)
    add(zones.rooms[i].name, zones.rooms[i].images, zones.rooms[i].mean, i);
  if (zones.rooms.empty())
    for (std::size_t i = 0; i < zones.zones.size(); ++i)
      add(zones.zones[i].name, zones.zones[i].images.size(), zones.zones[i].mean, i);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace estancia
