// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/home_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <unordered_set>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {
namespace {

using Json = nlohmann::json;

constexpr std::size_t maxPlanBytes = std::size_t{1} << 24;
constexpr std::size_t maxParts = 1000;
constexpr int maxPlanDepth = 16;
constexpr double maxCoordinate = 1e4;  // [m]
constexpr double minArea = 0.01;       // [m²]; smaller rooms cannot be entered

/// An element of the file and its name in messages: "home.json: rooms[2].polygon".
struct PlanElement {
  const Json& json;
  std::string where;

  [[noreturn]] void refuse(std::string_view expected) const {
    fail(ErrorCode::malformedFile, "{}: must be {}", where, expected);
  }

  const Json* findMember(const char* key) const {
    if (!json.is_object()) refuse("an object");
    const auto found = json.find(key);
    return found == json.end() ? nullptr : &*found;
  }

  PlanElement member(const char* key) const {
    const Json* found = findMember(key);
    if (found == nullptr) fail(ErrorCode::malformedFile, "{}: has no \"{}\"; add it", where, key);
    return {*found, fmt::format("{}.{}", where, key)};
  }

  std::vector<PlanElement> list() const {
    if (!json.is_array()) refuse("a list");
    if (json.size() > maxParts)
      fail(ErrorCode::tooLarge, "{}: {} elements; at most {} are read", where, json.size(), maxParts);
    std::vector<PlanElement> elements;
    for (std::size_t i = 0; i < json.size(); ++i)
      elements.push_back({json[i], fmt::format("{}[{}]", where, i)});
    return elements;
  }

  std::string text() const {
    if (!json.is_string() || json.get_ref<const std::string&>().empty()) refuse("a text that is not empty");
    return printable(json.get_ref<const std::string&>());
  }

  float meters() const {
    // JSON has no NaN, but 1e999.
    if (!json.is_number() || !(std::abs(json.get<double>()) <= maxCoordinate))
      refuse(fmt::format("a number of meters within {}", maxCoordinate));
    return json.get<float>();
  }

  cv::Point2f point() const {
    const auto numbers = list();
    if (numbers.size() != 2) refuse("[x, y]");
    return {numbers[0].meters(), numbers[1].meters()};
  }
};

Json parsePlan(const std::string& text, const std::string& source) {
  const auto shallow = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > maxPlanDepth)
      fail(ErrorCode::malformedFile, "{}: JSON with more than {} levels", source, maxPlanDepth);
    return true;
  };
  try {
    return Json::parse(text, shallow);
  } catch (const Json::exception& e) {
    fail(ErrorCode::malformedFile, "{}: {}", source, jsonProblem(e));
  }
}

HomeRoom roomOf(const PlanElement& element) {
  HomeRoom room{element.member("name").text(), {}};
  const PlanElement polygon = element.member("polygon");
  for (const PlanElement& corner : polygon.list()) room.polygon.push_back(corner.point());
  if (room.polygon.size() < 3 || cv::contourArea(room.polygon) < minArea)
    polygon.refuse("three corners or more around an area");
  return room;
}

HomeOpening openingOf(const PlanElement& element) {
  HomeOpening opening;
  opening.at = element.member("at").point();
  const PlanElement axis = element.member("axis"), width = element.member("width");
  opening.alongX = axis.text() == "x";
  if (!opening.alongX && axis.text() != "y") axis.refuse("\"x\" or \"y\", along which the wall runs");
  opening.width = width.meters();
  if (!(opening.width > 0)) width.refuse("above 0");
  if (const Json* room = element.findMember("room"))
    opening.rooms = {PlanElement{*room, element.where + ".room"}.text()};
  else
    for (const PlanElement& name : element.member("rooms").list()) opening.rooms.push_back(name.text());
  return opening;
}

std::vector<HomeOpening> openingsOf(const PlanElement& home, const char* key,
                                    const std::unordered_set<std::string>& rooms) {
  std::vector<HomeOpening> openings;
  if (home.findMember(key) == nullptr) return openings;
  for (const PlanElement& element : home.member(key).list()) {
    openings.push_back(openingOf(element));
    for (const std::string& room : openings.back().rooms)
      if (!rooms.contains(room))
        fail(ErrorCode::malformedFile, "{}: no room has the name \"{}\"; give one of \"rooms\"",
             element.where, room);
  }
  return openings;
}

}  // namespace

HomePlan readHomePlan(const std::filesystem::path& file) {
  const std::string source = printable(file);
  const Json json = parsePlan(readBytes(file, maxPlanBytes), source);
  const PlanElement home{json, source};
  HomePlan plan;
  if (home.findMember("name") != nullptr) plan.name = home.member("name").text();
  std::unordered_set<std::string> names;
  for (const PlanElement& element : home.member("rooms").list()) {
    plan.rooms.push_back(roomOf(element));
    if (!names.insert(plan.rooms.back().name).second)
      fail(ErrorCode::malformedFile, "{}: another room has the name \"{}\", too; name them apart",
           element.where, plan.rooms.back().name);
  }
  if (plan.rooms.empty()) home.member("rooms").refuse("a list of one room or more");
  plan.doors = openingsOf(home, "doors", names);
  plan.windows = openingsOf(home, "windows", names);
  return plan;
}

std::optional<std::size_t> roomAt(const HomePlan& plan, double x, double y) {
  const cv::Point2f at(static_cast<float>(x), static_cast<float>(y));
  const auto found = std::ranges::find_if(plan.rooms, [&](const HomeRoom& room) {
    return cv::pointPolygonTest(room.polygon, at, /*measureDist=*/false) >= 0;
  });
  if (found == plan.rooms.end()) return std::nullopt;
  return static_cast<std::size_t>(found - plan.rooms.begin());
}

}  // namespace estancia::io
