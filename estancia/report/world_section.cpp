// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/world_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <unordered_map>

#include "estancia/world_query/world_json.hpp"

namespace estancia::report {
namespace {

double inCentimeters(double meters) {
  return std::round(meters * 100) / 100;
}

/// Simplified to within 5 cm.
nlohmann::json pathJson(const std::vector<cv::Point2d>& way) {
  std::vector<cv::Point2f> points, corners;
  for (const cv::Point2d& point : way)
    points.emplace_back(static_cast<float>(point.x - way.front().x),
                        static_cast<float>(point.y - way.front().y));
  cv::approxPolyDP(points, corners, 0.05, false);
  nlohmann::json path = nlohmann::json::array();
  for (const cv::Point2f& corner : corners)
    path.push_back({inCentimeters(way.front().x + static_cast<double>(corner.x)),
                    inCentimeters(way.front().y + static_cast<double>(corner.y))});
  return path;
}

void addDrivenWay(nlohmann::json& json, const WorldRoute& route) {
  json["cost"] = route.route.cost;
  if (!route.driven) return;
  json["length"] = inCentimeters(route.driven->length);
  json["way"] = pathJson(route.driven->points);
}

/// Content of the panel before the first question.
void addAreaIndex(Markup& section, const WorldMap& world) {
  if (world.areas.empty()) return;
  section.element("h2", "Areas").open("ul", {{"class", "area-index"}});
  for (const WorldArea& area : world.areas) {
    const auto objects = static_cast<std::size_t>(
        std::ranges::count(world.objects, area.id, [](const WorldObject& object) { return object.area; }));
    section.open("li").open("a", {{"href", fmt::format("#area-{}", area.id)}});
    section.add(symbol({areaColor(area.id)}));
    section.element("span", {{"class", "label"}}, shorten(area.displayName(), 40));
    section.element("span", {{"class", "p"}}, counted(objects, "object")).close().close();
  }
  section.close();
}

void addPlanGuide(Markup& section, bool ways) {
  section.open("div", {{"class", "panel guide"}}).element("h2", "How to read this plan");
  section.element(
      "p",
      "Seen from above: areas are tinted and named, walls dark, the driven path dotted. An object "
      "is a small image where there is room, else a dot in its color; the thin line is its box.");
  section.element("p",
                  ways ? "Select an object, or search a word: the plan shows the way along the driven path "
                         "from the ring, and the arrow is where to stand and look."
                       : "Select an object, or search a word, to see its words and its image.");
  section.close();
}

}  // namespace

Markup worldSection(const WorldView& view, const Markup& searchForm) {
  const PlanShapes shapes = view.world.plan ? shapesOf(*view.world.plan) : PlanShapes();
  Markup section;
  section.add(imageSymbols(view));
  section.open("section", {{"class", "explore"}, {"id", "world"}, {"aria-label", "Floor plan"}});
  section.add(searchForm);
  section.open("div", {{"class", "figure"}});
  section.add(worldFigure(view, shapes, {780, 760, 12.5, true, "wide"}));
  section.add(worldFigure(view, shapes, {358, 520, 11, false, "narrow"}));
  section.close().open("div", {{"class", "side"}});
  Attributes panel{{"class", "panel"}, {"id", "found"}, {"aria-live", "polite"}};
  if (view.world.areas.empty()) panel.push_back({"hidden", ""});
  section.open("div", panel);
  addAreaIndex(section, view.world);
  section.close().close();
  addPlanGuide(section, view.start().has_value());
  section.element("div", {{"id", "tip"}, {"hidden", ""}, {"aria-hidden", "true"}}, "");
  return section.close();
}

std::string exampleWord(const WorldMap& world) {
  const WorldObject* example = nullptr;
  for (const WorldObject& object : world.objects)
    if (!object.words.empty() && (example == nullptr || object.probability() > example->probability()))
      example = &object;
  return example == nullptr ? "" : shorten(firstSynonym(example->words.front().label), 30);
}

nlohmann::json worldData(const WorldView& view) {
  const WorldMap& world = view.world;
  std::unordered_map<std::string_view, std::size_t> numbers;
  for (std::size_t i = 0; i < world.places.vocabulary.size(); ++i)
    numbers.emplace(world.places.vocabulary[i], i);
  nlohmann::json objects = nlohmann::json::array(), areas = objects;
  for (const WorldObject& object : world.objects) {
    nlohmann::json words = nlohmann::json::array();
    constexpr std::size_t most = 20;
    for (std::size_t i = 0; i < std::min(most, object.words.size()); ++i)
      if (const auto number = numbers.find(object.words[i].label); number != numbers.end())
        words.push_back(
            {number->second, std::lround(1e4 * static_cast<double>(object.words[i].probability))});
    nlohmann::json json{{"name", shorten(object.displayName(), 60)},
                        {"given", cleanText(object.givenName)},
                        {"words", words},
                        {"probability", probabilityText(object)},
                        {"where", shorten(whereText(object, world), 120)}};
    if (const auto& route = view.routes[static_cast<std::size_t>(object.id)]) {
      const ViewPose& pose = *route->pose;
      json["pose"] = {inCentimeters(pose.x), inCentimeters(pose.y), std::round(pose.yaw * 1e4) / 1e4};
      json["distance"] = inCentimeters(pose.distance);
      json["frame"] = cleanText(world.places.frames[pose.frame].name);
      addDrivenWay(json, *route);
    }
    objects.push_back(std::move(json));
  }
  for (const WorldArea& area : world.areas) {
    nlohmann::json json{{"id", area.id},
                        {"name", shorten(area.displayName(), 60)},
                        {"given", cleanText(area.givenName)},
                        {"room", cleanText(area.roomName)}};
    if (const auto& route = view.areaRoutes[static_cast<std::size_t>(area.id)]) addDrivenWay(json, *route);
    areas.push_back(std::move(json));
  }
  return {{"from", view.from}, {"objects", objects}, {"areas", areas}};
}

namespace {

std::vector<const WorldObject*> objectsIn(const WorldMap& world, int area) {
  std::vector<const WorldObject*> objects;
  for (const WorldObject& object : world.objects)
    if (object.area == area) objects.push_back(&object);
  std::ranges::stable_sort(objects, [](auto* a, auto* b) {
    return a->givenName.empty() != b->givenName.empty() ? b->givenName.empty()
                                                        : a->probability() > b->probability();
  });
  return objects;
}

/// The best words with their probabilities, for the pointer that rests on it.
std::string wordsText(const WorldObject& object) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, object.words.size()); ++i)
    text += fmt::format("{}{} {:.0f} %", i == 0 ? "" : ", ", shorten(firstSynonym(object.words[i].label), 32),
                        100 * static_cast<double>(object.words[i].probability));
  return text;
}

void addItem(Markup& out, const WorldView& view, const WorldObject& object) {
  out.open("li").open("a", {{"class", "item"},
                            {"id", fmt::format("object-{}", object.id)},
                            {"href", "#world"},
                            {"data-object", object.id},
                            {"title", wordsText(object)}});
  if (view.images.contains(object.id)) {
    out.open("svg", {{"viewBox", "0 0 1 1"}, {"aria-hidden", "true"}});
    out.leaf("use", {{"href", fmt::format("#image-{}", object.id)}, {"width", 1}, {"height", 1}}).close();
  } else {
    const auto& [red, green, blue] = object.color;
    out.element("i", {{"style", "background:" + Color{red, green, blue}.hex()}}, "");
  }
  out.open("span").element("b", shorten(object.displayName(), 40));
  const std::string on = supportText(object, view.world);
  for (const std::string& more : {probabilityText(object), shorten(shapeText(object), 60), shorten(on, 60)})
    if (!more.empty()) out.element("small", more);
  out.close().close().close();
}

void addArea(Markup& out, const WorldView& view, const WorldArea* area) {
  const std::vector<const WorldObject*> objects = objectsIn(view.world, area == nullptr ? -1 : area->id);
  if (area == nullptr && objects.empty()) return;
  out.open("article",
           {{"class", "card inside"},
            {"id", area == nullptr ? std::string("area-none") : fmt::format("area-{}", area->id)}});
  out.open("header");
  if (area != nullptr) out.add(badge({areaColor(area->id)}, std::to_string(area->id)));
  out.open("div").element("h3", area == nullptr ? "In no area" : shorten(area->describedName(), 80));
  out.element("p", (area == nullptr ? ""
                                    : fmt::format("{:.1f} m² · {} · ", area->size,
                                                  area->frames == 0 ? "only looked into"
                                                                    : counted(area->frames, "frame"))) +
                       counted(objects.size(), "object"));
  out.close().close();
  if (!objects.empty()) {
    out.open("ul", {{"class", "items"}});
    for (const WorldObject* object : objects) addItem(out, view, *object);
    out.close();
  }
  out.close();
}

}  // namespace

Markup worldList(const WorldView& view) {
  Markup section;
  if (view.world.areas.empty() && view.world.objects.empty()) return section;
  section.open("section", {{"id", "areas"}});
  section.element("h2", view.world.areas.empty() ? "Objects" : "Areas and the objects in them");
  if (view.withheld > 0)
    section.element("p", {{"class", "note"}},
                    counted(view.withheld, "image") + " left out to keep this page small.");
  const bool alone = view.world.areas.size() + (objectsIn(view.world, -1).empty() ? 0 : 1) == 1;
  section.open("div", {{"class", alone ? "insides alone" : "insides"}});
  for (const WorldArea& area : view.world.areas) addArea(section, view, &area);
  addArea(section, view, nullptr);
  return section.close().close();
}

}  // namespace estancia::report
