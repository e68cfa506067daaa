// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/world_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "estancia/figures/label_places.hpp"

namespace estancia::report {
namespace {

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

Markup worldFigure(const WorldView& view, const PlanShapes& shapes, FigureStyle style) {
  return WorldDrawing(view, shapes, std::move(style)).draw();
}

}  // namespace estancia::report
