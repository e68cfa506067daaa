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

struct AreaName {
  std::string text;
  Point at;
  Box box;
};

/// Leading words between commas that fit into so many code points.
std::string wordsWithin(const std::string& name, std::size_t most) {
  const std::string text = shorten(name, most);
  const std::size_t comma = text.rfind(',');
  return text.ends_with("…") && comma != std::string::npos && comma > 0 ? text.substr(0, comma) : text;
}

class WorldDrawing {
 public:
  WorldDrawing(const WorldView& view, const PlanShapes& shapes, FigureStyle style)
      : view_(view), shapes_(shapes), style_(std::move(style)) {
    const std::vector<Point> extent = pointsToShow();
    const double below = 1.4 * style_.fontSize, borders = 2 * figureMargin + below;
    const auto fitNow = [&] {
      return fitInto(extent,
                     {figureMargin, figureMargin, style_.width - 2 * figureMargin, style_.height - borders},
                     false);
    };
    style_.height = neededHeight(fitNow(), extent, style_, borders);
    fit_ = fitNow();
    placeNames();
  }

  Markup draw() {
    Markup svg = openFigure("plan", style_,
                            "Floor plan with " + counted(view_.world.areas.size(), "area") + " and " +
                                counted(view_.world.objects.size(), "object"));
    svg.open("g", {{"class", "floor"},
                   {"data-fit", fmt::format("{} {} {} {} {}", number(fit_.scale, 4), number(fit_.from.x, 4),
                                            number(fit_.from.y, 4), number(fit_.to.x), number(fit_.to.y))}});
    drawAreas(svg);
    if (!shapes_.walls.empty())
      svg.leaf("path", {{"class", "walls"}, {"fill-rule", "evenodd"}, {"d", pathOf(shapes_.walls, fit_)}});
    drawPath(svg, view_.path, fit_, view_.driveStarts);
    drawBoxes(svg);
    drawThings(svg);
    svg.open("g", {{"class", "way"}}).close();
    if (const auto start = view_.start()) {
      svg.open("g", {{"class", "start"}}).element("title", "The ways start here");
      svg.leaf("circle", {{"cx", fit_(*start).x}, {"cy", fit_(*start).y}, {"r", 5}}).close();
    }
    for (const AreaName& name : names_)
      addText(svg, "area-name", name.at, style_.fontSize, name.text, "middle");
    drawScale(svg, fit_.scale, style_);
    return svg.close().close();
  }

 private:
  std::vector<Point> pointsToShow() const {
    std::vector<Point> points;
    const auto add = [&points](const Outlines& outlines) {
      for (const auto& outline : outlines) points.insert(points.end(), outline.begin(), outline.end());
    };
    add(shapes_.walls);
    for (const Outlines& area : shapes_.areas) add(area);
    add(view_.boxes);
    for (const auto& point : view_.path)
      if (point) points.push_back(*point);
    return points;
  }

  /// nullptr where the area has none.
  const Outlines* shapeOf(const WorldArea& area) const {
    const auto number = static_cast<std::size_t>(area.id);
    return number < shapes_.areas.size() && !shapes_.areas[number].empty() ? &shapes_.areas[number] : nullptr;
  }

  /// On the figure.
  double widthOf(const Outlines& area) const {
    Extent drawn;
    for (const std::vector<Point>& outline : area)
      for (const Point& corner : outline) drawn.add(fit_(corner));
    return drawn.high.x - drawn.low.x;
  }

  /// Part of the name that fits into the area; its number where not even a short word does.
  std::string nameOf(const WorldArea& area, double width) const {
    constexpr std::size_t least = 6;
    for (std::size_t most = style_.words ? 28 : 16; most >= least; --most)
      if (std::string text = wordsWithin(area.displayName(), most);
          1.08 * style_.fontSize * textWidth(text) <= width)
        return text;
    return std::to_string(area.id);
  }

  /// Each at the middle of its area, or a little above or below, so that none covers another.
  void placeNames() {
    for (const WorldArea& area : view_.world.areas) {
      const Outlines* shape = shapeOf(area);
      if (shape == nullptr) continue;
      const double size = style_.fontSize;
      const std::string text = nameOf(area, widthOf(*shape));
      const double width = 1.08 * size * textWidth(text);
      Point at = fit_({area.center.x, area.center.y});
      at.x = std::clamp(at.x, width / 2 + 2, std::max(width / 2 + 2, style_.width - width / 2 - 2));
      for (const double shift : {0.0, -1.3, 1.3, -2.6, 2.6}) {
        const Point middle{at.x, at.y + shift * size};
        const Box box{at.x - width / 2, middle.y - 0.65 * size, width, 1.3 * size};
        if (std::ranges::any_of(names_, [&box](const AreaName& name) { return name.box.overlaps(box); }))
          continue;
        names_.push_back({text, {at.x, middle.y + 0.35 * size}, box});
        break;
      }
    }
  }

  void drawAreas(Markup& svg) const {
    for (const WorldArea& area : view_.world.areas) {
      const Outlines* shape = shapeOf(area);
      if (shape == nullptr) continue;
      const std::string color = areaColor(area.id).hex();
      svg.open("a", {{"class", "area"}, {"href", fmt::format("#area-{}", area.id)}});
      svg.element("title", fmt::format("{}: {:.1f} m², {}", shorten(area.describedName(), 80), area.size,
                                       counted(area.frames, "frame")));
      svg.leaf("path",
               {{"fill", color}, {"stroke", color}, {"fill-rule", "evenodd"}, {"d", pathOf(*shape, fit_)}});
      svg.close();
    }
  }

  void drawBoxes(Markup& svg) const {
    for (const WorldObject& object : view_.world.objects) {
      const std::vector<Point>& box = view_.boxes[static_cast<std::size_t>(object.id)];
      if (!box.empty())
        svg.leaf("path", {{"class", "box"}, {"data-object", object.id}, {"d", pathOf({box}, fit_)}});
    }
  }

  /// Objects seen most often get room for their images first.
  void drawThings(Markup& svg) const {
    Thumbnails room({2, 2, style_.width - 4, style_.height - 4}, style_.words ? 34 : 24);
    for (const AreaName& name : names_) room.block(name.box);
    std::vector<const WorldObject*> order;
    for (const WorldObject& object : view_.world.objects)
      if (!view_.boxes[static_cast<std::size_t>(object.id)].empty()) order.push_back(&object);
    std::ranges::stable_sort(order, [](auto* a, auto* b) { return a->views > b->views; });
    for (const WorldObject* object : order) {
      const Point at = fit_(view_.centerOf(*object));
      const bool hasImage = view_.images.contains(object->id);
      drawThing(svg, *object, at, hasImage ? room.take(at) : std::nullopt);
    }
  }

  void drawThing(Markup& svg, const WorldObject& object, const Point& at,
                 const std::optional<Box>& image) const {
    const std::string name = shorten(object.displayName(), 40), where = whereText(object, view_.world);
    const std::string title = name + (where.empty() ? "" : ", " + shorten(where, 80));
    svg.open("a", {{"class", "thing"},
                   {"href", fmt::format("#object-{}", object.id)},
                   {"data-object", object.id},
                   {"aria-label", title}});
    const bool beside = image && !image->overlapsCircle(at, 0.1);
    if (image) {
      const Point middle{image->x + image->width / 2, image->y + image->height / 2};
      if (beside)
        svg.leaf("path",
                 {{"class", "leader"}, {"d", Path().move(at.x, at.y).line(middle.x, middle.y).str()}});
      svg.leaf("use", {{"href", fmt::format("#image-{}", object.id)},
                       {"x", image->x},
                       {"y", image->y},
                       {"width", image->width},
                       {"height", image->height}});
      svg.leaf("rect",
               {{"x", image->x}, {"y", image->y}, {"width", image->width}, {"height", image->height}});
    }
    if (!image || beside) {
      if (!image) svg.leaf("circle", {{"class", "finger"}, {"cx", at.x}, {"cy", at.y}, {"r", 11}});
      const auto& [red, green, blue] = object.color;
      svg.leaf("circle", {{"class", "dot"},
                          {"cx", at.x},
                          {"cy", at.y},
                          {"r", image ? 2.5 : 4.5},
                          {"fill", Color{red, green, blue}.hex()}});
    }
    svg.close();
  }

  const WorldView& view_;
  const PlanShapes& shapes_;
  FigureStyle style_;
  Fit fit_;
  std::vector<AreaName> names_;
};

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

Markup worldFigure(const WorldView& view, const PlanShapes& shapes, FigureStyle style) {
  return WorldDrawing(view, shapes, std::move(style)).draw();
}

Point onFloor(const Floor& floor, const cv::Vec3d& at) {
  const cv::Point2d point = floor.position(at);
  return {point.x, point.y};
}

std::vector<Point> boxOnFloor(const WorldObject& object, const Floor& floor) {
  for (const double value : {object.center.x, object.center.y, object.center.z, object.size.x, object.size.y})
    if (!(std::abs(value) < 1e6)) return {};  // [m]
  const Point center = onFloor(floor, object.center);
  const double c = std::cos(object.yaw), s = std::sin(object.yaw);
  const double x = object.size.x / 2, y = object.size.y / 2;
  std::vector<Point> corners;
  for (const Point& corner : {Point{-x, -y}, Point{x, -y}, Point{x, y}, Point{-x, y}})
    corners.push_back({center.x + c * corner.x - s * corner.y, center.y + s * corner.x + c * corner.y});
  return corners;
}

namespace {

/// The images of what was seen most often first, as many as there is room for.
void loadObjectImages(const WorldPage& page, WorldView& view) {
  if (!page.image) return;
  std::vector<const WorldObject*> order;
  for (const WorldObject& object : page.world.objects) order.push_back(&object);
  std::ranges::stable_sort(order, [](auto* a, auto* b) { return a->views > b->views; });
  std::size_t left = page.bytes;
  for (const WorldObject* object : order) {
    const std::vector<unsigned char> bytes = page.image(object->id);
    if (bytes.empty()) continue;
    if (bytes.size() > left) {
      ++view.withheld;
      continue;
    }
    left -= bytes.size();
    view.images.emplace(object->id, imageUri(bytes, fmt::format("the image of object {}", object->id)));
  }
}

}  // namespace

Point WorldView::centerOf(const WorldObject& object) const {
  return onFloor(floor, object.center);
}

std::optional<Point> WorldView::start() const {
  for (const std::optional<WorldRoute>& route : routes)
    if (route && route->driven)
      return Point{route->driven->points.front().x, route->driven->points.front().y};
  return std::nullopt;
}

bool hasLayers(const WorldMap& world) {
  return world.plan.has_value() || !world.objects.empty();
}

WorldView viewOf(const WorldPage& page) {
  const WorldMap& world = page.world;
  WorldView view{world, floorOf(world)};
  for (const Drive& drive : world.places.drives) view.driveStarts.push_back(drive.firstFrame);
  for (const MappedFrame& frame : world.places.frames) {
    view.path.emplace_back();
    if (frame.pose && frame.pose->isPlausible())
      view.path.back() = onFloor(view.floor, {frame.pose->x, frame.pose->y, frame.pose->z});
  }
  for (const WorldObject& object : world.objects) view.boxes.push_back(boxOnFloor(object, view.floor));
  loadObjectImages(page, view);
  view.routes.resize(world.objects.size());
  view.areaRoutes.resize(world.areas.size());
  if (world.places.nodes.empty()) return view;
  view.from = page.from.value_or(world.places.frames.empty() ? world.places.nodes.front().id
                                                             : world.places.frames.front().node);
  view.routes = routesToObjects(world, view.from);
  view.areaRoutes = routesToEachArea(world, view.from);
  return view;
}

Color areaColor(int area) {
  constexpr std::size_t hues = 7, tones = 3;
  const auto number = static_cast<std::size_t>(area);
  const std::size_t round = number / hues;
  // Other hues first in each round, and the darker tone: areas of near numbers are often neighbors.
  return classStyle((number + 3 * round) % hues + distinctClasses / tones * (2 * round % tones)).fill;
}

Markup imageSymbols(const WorldView& view) {
  Markup svg;
  svg.open("svg", {{"class", "symbols"}, {"aria-hidden", "true"}});
  for (const auto& [object, uri] : view.images) {
    svg.open("symbol", {{"id", fmt::format("image-{}", object)}, {"viewBox", "0 0 1 1"}});
    svg.leaf("image",
             {{"width", 1}, {"height", 1}, {"preserveAspectRatio", "xMidYMid slice"}, {"href", uri}});
    svg.close();
  }
  return svg.close();
}

std::string probabilityText(const WorldObject& object) {
  if (!object.givenName.empty()) return "named by people";
  if (object.known) return fmt::format("recognized, {:.0f} %", 100 * object.known->confidence);
  return object.words.empty() ? "" : fmt::format("{:.0f} %", 100 * object.probability());
}

std::string whereText(const WorldObject& object, const WorldMap& world) {
  std::string where = supportText(object, world);
  if (const WorldArea* area = world.findArea(object.area))
    where += (where.empty() ? "in " : ", in ") + area->displayName();
  return where;
}

}  // namespace estancia::report
