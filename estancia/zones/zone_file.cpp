// SPDX-License-Identifier: Apache-2.0
#include "estancia/zones/zones.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/core/printable_labels.hpp"
#include "estancia/files/files.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view format = "estancia-zones";
constexpr std::uint64_t version = 3;

// ---- writing

/// The number with the fewest digits that reads back as this float32: 0.2, not 0.20000000298023224.
double shortest(float value) {
  const std::string digits = fmt::format("{}", value);
  double decimal = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), decimal);
  return static_cast<float>(decimal) == value ? decimal : static_cast<double>(value);
}

Json toJson(const std::vector<float>& values) {
  Json list = Json::array();
  for (const float value : values) list.push_back(shortest(value));
  return list;
}

/// Names of files and labels may be no UTF-8, which JSON cannot hold.
Json toJson(const std::string& text) {
  try {
    Json json = text;
    static_cast<void>(json.dump());
    return json;
  } catch (const Json::exception&) {
    std::string hex;
    for (const char c : text) hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
    return {{"hex", hex}};
  }
}

Json toJson(const Frame& frame, int zone) {
  Json json{{"name", toJson(frame.name)}, {"zone", zone}};
  if (frame.timestamp) json["timestamp"] = *frame.timestamp;
  if (const auto& p = frame.pose) json["pose"] = {p->x, p->y, p->z, p->qx, p->qy, p->qz, p->qw};
  if (!frame.room.empty()) json["room"] = toJson(frame.room);
  return json;
}

Json toJson(const Zone& zone) {
  Json json{{"id", zone.id}, {"name", toJson(zone.name)}, {"images", zone.images.size()}};
  if (!zone.room.empty()) {
    json["room"] = toJson(zone.room);
    json["room_share"] = zone.roomShare;
  }
  if (zone.extent)
    json["extent"] = {
        {"center", zone.extent->center}, {"spread", zone.extent->spread}, {"images", zone.extent->images}};
  for (const auto& [room, probability] : zone.predicted)
    json["predicted"].push_back({{"room", toJson(room)}, {"p", probability}});
  json["mean"] = toJson(zone.mean);
  json["sigma"] = toJson(zone.sigma);
  return json;
}

Json toJson(const Vocabulary& vocabulary) {
  Json labels = Json::array(), parts = Json::array();
  for (const std::string& label : vocabulary.labels()) labels.push_back(toJson(label));
  for (const LabelPart& part : vocabulary.layout().parts)
    parts.push_back({{"size", part.size}, {"weight", shortest(part.weight)}});
  return {{"digest", vocabulary.digest()}, {"labels", labels}, {"parts", parts}};
}

/// One element a line: the file stays readable, and two of them comparable line by line.
std::string lines(const char* key, const Json& list) {
  std::string text = fmt::format(" \"{}\": [", key);
  for (std::size_t i = 0; i < list.size(); ++i)
    text += fmt::format("{}\n  {}", i == 0 ? "" : ",", list[i].dump());
  return text + "]";
}

// ---- reading: whatever is wrong throws Json::exception or Error

template <class... Args>
[[noreturn]] void damaged(fmt::format_string<Args...> how, Args&&... args) {
  fail(ErrorCode::corruptFile, how, std::forward<Args>(args)...);
}

/// A whole number below `end`.
std::uint64_t indexIn(const Json& json, std::uint64_t end, const char* what) {
  if (!json.is_number_unsigned() || json.get<std::uint64_t>() >= end)
    damaged("{} is {}, not below {}", what, json.dump().substr(0, 30), end);
  return json.get<std::uint64_t>();
}

double numberIn(const Json& json, const char* what) {
  if (!json.is_number() || !std::isfinite(json.get<double>())) damaged("{} is not a number", what);
  return json.get<double>();
}

int digitOf(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  damaged("a text is not hexadecimal");
}

std::string rawTextIn(const Json& json) {
  if (!json.is_object()) return json.get<std::string>();
  const auto hex = json.at("hex").get<std::string>();
  std::string text;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    text += static_cast<char>(digitOf(hex[i]) * 16 + digitOf(hex[i + 1]));
  return text;
}

std::string textIn(const Json& json) {
  return printable(rawTextIn(json));
}

std::vector<float> probabilitiesIn(const Json& json, std::size_t labels, const std::string& what) {
  if (!json.is_array() || json.size() != labels)
    damaged("{} does not have one number for each of the {} labels", what, labels);
  std::vector<float> values;
  values.reserve(labels);
  for (const Json& value : json) values.push_back(static_cast<float>(numberIn(value, what.c_str())));
  requireProbabilities(values, labels, what);
  return values;
}

template <std::size_t N>
std::array<double, N> numbersIn(const Json& json, const char* what) {
  if (!json.is_array() || json.size() != N) damaged("{} does not have {} numbers", what, N);
  std::array<double, N> numbers{};
  for (std::size_t i = 0; i < N; ++i) numbers[i] = numberIn(json[i], what);
  return numbers;
}

const Json& listIn(const Json& json, const char* key) {
  const Json& list = json.at(key);
  if (!list.is_array()) damaged("\"{}\" is not a list", key);
  return list;
}

Vocabulary vocabularyIn(const Json& json) {
  std::vector<std::string> labels;
  for (const Json& label : listIn(json, "labels")) labels.push_back(rawTextIn(label));
  std::vector<LabelPart> parts;
  for (const Json& part : listIn(json, "parts"))
    parts.push_back({indexIn(part.at("size"), labels.size() + 1, "the size of a part"),
                     static_cast<float>(numberIn(part.at("weight"), "the weight of a part"))});
  if (parts.size() > labels.size()) damaged("it has more parts than labels");
  Vocabulary vocabulary(std::move(labels), std::move(parts));
  if (vocabulary.digest() != json.at("digest").get<std::string>())
    damaged("its labels do not match their digest");
  return printableLabels(vocabulary);
}

Frame frameIn(const Json& json) {
  Frame frame;
  frame.name = textIn(json.at("name"));
  if (json.contains("timestamp")) frame.timestamp = numberIn(json["timestamp"], "a timestamp");
  if (json.contains("pose")) {
    const auto p = numbersIn<7>(json["pose"], "a pose");
    frame.pose = Pose{p[0], p[1], p[2], p[3], p[4], p[5], p[6]};
  }
  if (json.contains("room")) frame.room = textIn(json["room"]);
  return frame;
}

/// `images` are the frames that the file assigns to it.
Zone zoneIn(const Json& json, int id, std::vector<std::size_t> images, const Zones& zones) {
  if (json.at("id") != id) damaged("zone {} has the id {}", id, json["id"].dump());
  Zone zone;
  zone.id = id;
  zone.name = textIn(json.at("name"));
  if (json.contains("room")) {
    zone.room = textIn(json["room"]);
    zone.roomShare = numberIn(json.at("room_share"), "the share of a room");
  }
  const std::uint64_t end = zones.frames.size() + 1;
  if (json.contains("extent")) {
    const Json& extent = json["extent"];
    zone.extent = ZoneExtent{numbersIn<3>(extent.at("center"), "the center of a zone"),
                             numberIn(extent.at("spread"), "the spread of a zone"),
                             indexIn(extent.at("images"), end, "a number of posed images")};
  }
  if (json.contains("predicted"))
    for (const Json& room : listIn(json, "predicted")) {
      const double p = numberIn(room.at("p"), "the probability of a predicted room");
      if (p < 0 || p > 1) damaged("the probability of a predicted room is {}", p);
      zone.predicted.push_back({textIn(room.at("room")), p});
    }
  const std::size_t labels = zones.vocabulary.size();
  zone.mean = probabilitiesIn(json.at("mean"), labels, fmt::format("the mean of zone {}", id));
  zone.sigma = probabilitiesIn(json.at("sigma"), labels, fmt::format("the sigma of zone {}", id));
  zone.images = std::move(images);
  if (zone.images.empty() || json.at("images") != zone.images.size())
    damaged("zone {} has {} frames, but its number of images differs", id, zone.images.size());
  return zone;
}

RoomWords roomIn(const Json& json, const Zones& zones) {
  RoomWords room{textIn(json.at("name")), 0, {}};
  room.images = indexIn(json.at("images"), zones.frames.size() + 1, "a number of images");
  room.mean = probabilitiesIn(json.at("mean"), zones.vocabulary.size(), "the mean of a room");
  return room;
}

Dendrogram dendrogramIn(const Json& json, std::size_t leaves) {
  std::vector<Dendrogram::Merge> merges;
  for (const Json& row : json) {
    if (!row.is_array() || row.size() != 4) damaged("a merge does not have four numbers");
    merges.push_back(
        {indexIn(row[0], 2 * leaves, "a merged cluster"), indexIn(row[1], 2 * leaves, "a merged cluster"),
         numberIn(row[2], "the height of a merge"), indexIn(row[3], leaves + 1, "the size of a merge")});
  }
  return {leaves, std::move(merges)};
}

Zones zonesIn(const Json& json) {
  const Json& settings = json.at("settings");
  Zones zones{.vocabulary = vocabularyIn(json.at("vocabulary")),
              .model = textIn(json.at("model")),
              .distance = textIn(settings.at("distance")),
              .linkage = textIn(settings.at("linkage")),
              .cut = numberIn(settings.at("cut"), "the cut"),
              .cutReason = textIn(settings.at("cut_reason"))};
  const Json& list = listIn(json, "zones");
  std::vector<std::vector<std::size_t>> images(list.size());
  for (const Json& frame : listIn(json, "frames")) {
    const std::size_t zone = indexIn(frame.at("zone"), list.size(), "the zone of a frame");
    images[zone].push_back(zones.frames.size());
    zones.zoneOf.push_back(static_cast<int>(zone));
    zones.frames.push_back(frameIn(frame));
  }
  if (zones.frames.empty()) damaged("it has no frames");
  for (std::size_t id = 0; id < list.size(); ++id)
    zones.zones.push_back(zoneIn(list[id], static_cast<int>(id), std::move(images[id]), zones));
  for (const Json& room : listIn(json, "rooms")) zones.rooms.push_back(roomIn(room, zones));
  if (json.contains("classifier")) zones.classifier = textIn(json["classifier"]);
  if (json.contains("dendrogram"))
    zones.dendrogram = dendrogramIn(listIn(json, "dendrogram"), zones.frames.size());
  return zones;
}

}  // namespace

std::string zoneFileText(const Zones& zones) {
  Json head{{"format", format},
            {"version", version},
            {"vocabulary", toJson(zones.vocabulary)},
            {"model", toJson(zones.model)},
            {"settings",
             {{"distance", zones.distance},
              {"linkage", zones.linkage},
              {"cut", zones.cut},
              {"cut_reason", toJson(zones.cutReason)}}}};
  if (!zones.classifier.empty()) head["classifier"] = toJson(zones.classifier);
  Json list = Json::array(), rooms = Json::array(), frames = Json::array();
  for (const Zone& zone : zones.zones) list.push_back(toJson(zone));
  for (const RoomWords& room : zones.rooms)
    rooms.push_back({{"name", toJson(room.name)}, {"images", room.images}, {"mean", toJson(room.mean)}});
  for (std::size_t i = 0; i < zones.frames.size(); ++i)
    frames.push_back(toJson(zones.frames[i], zones.zoneOf[i]));
  std::string text = "{\n";
  for (const auto& [key, value] : head.items()) text += fmt::format(" \"{}\": {},\n", key, value.dump());
  text += lines("zones", list) + ",\n" + lines("rooms", rooms) + ",\n" + lines("frames", frames);
  if (zones.dendrogram) {
    Json merges = Json::array();
    for (const auto& [left, right, height, size] : zones.dendrogram->merges())
      merges.push_back({left, right, height, size});
    text += ",\n" + lines("dendrogram", merges);
  }
  return text + "\n}\n";
}

void writeZones(const Zones& zones, const fs::path& file) {
  writeWhole(file, zoneFileText(zones));
}

Zones readZones(const fs::path& file) {
  const std::string text = io::readBytes(file, std::size_t{2} << 30);
  const auto refuse = [&file](const std::string& how) {
    fail(ErrorCode::corruptFile, "{}: damaged or cut short ({}); make it again by `estancia zones find`",
         file.string(), how.substr(0, 200));
  };
  if (!isZoneFile(file))
    fail(ErrorCode::unsupportedFile,
         "{}: not a zone file; give one that `estancia zones find` or `areas find` has written",
         file.string());
  std::uint64_t found = 0;
  try {
    const Json json = Json::parse(text, [](int depth, Json::parse_event_t, Json&) {
      if (depth > 8) damaged("it has more than 8 levels");
      return true;
    });
    found = indexIn(json.at("version"), std::numeric_limits<std::uint64_t>::max(), "the version");
    if (found == version) return zonesIn(json);
  } catch (const Json::exception& e) {
    refuse(io::jsonProblem(e));
  } catch (const Error& e) {
    refuse(e.what());
  }
  fail(ErrorCode::unsupportedFile, "{}: zone file version {}, but this Estancia reads version {}; {}",
       file.string(), found, version,
       found < version ? "make it again by `estancia zones find`" : "update Estancia");
}

bool isZoneFile(const fs::path& file) {
  std::string start(256, ' ');
  std::error_code none;
  if (!fs::is_regular_file(file, none)) return false;
  std::ifstream(file, std::ios::binary).read(start.data(), static_cast<std::streamsize>(start.size()));
  std::erase_if(start, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
  return start.starts_with(fmt::format(R"({{"format":"{}")", format));
}

}  // namespace estancia
