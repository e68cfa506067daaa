// SPDX-License-Identifier: Apache-2.0
#include "estancia/figures/floor_plan.hpp"

#include <fstream>

#include "estancia/core/fail.hpp"
#include "estancia/figures/driven_path.hpp"
#include "estancia/files/home_plan.hpp"

namespace estancia {
namespace {

using namespace report;

void drawImage(Markup& svg, const FloorPlan& plan, const Fit& fit) {
  const Point corner = fit({plan.xMin, plan.yMax});
  svg.leaf("image", {{"class", "plan"},
                     {"href", imageUri(plan.image, "the floor plan")},
                     {"x", corner.x},
                     {"y", corner.y},
                     {"width", (plan.xMax - plan.xMin) * fit.scale},
                     {"height", (plan.yMax - plan.yMin) * fit.scale},
                     {"preserveAspectRatio", "none"}});
}

void drawOpening(Markup& svg, const char* kind, const io::HomeOpening& opening, const Fit& fit) {
  const double half = opening.width / 2;
  const Point along = opening.alongX ? Point{half, 0} : Point{0, half};
  const Point a = fit({opening.at.x - along.x, opening.at.y - along.y}),
              b = fit({opening.at.x + along.x, opening.at.y + along.y});
  svg.leaf("path", {{"class", kind}, {"d", Path().move(a.x, a.y).line(b.x, b.y).str()}});
}

/// In the upper left corner, where few nodes are.
void drawName(Markup& svg, const io::HomeRoom& room, const Fit& fit, double size) {
  Extent drawn;
  for (const cv::Point2f& corner : room.polygon) drawn.add(fit({corner.x, corner.y}));
  const std::string name = shorten(room.name, 22);
  if (size * textWidth(name) < drawn.high.x - drawn.low.x - size)
    addText(svg, "word", {drawn.low.x + 0.5 * size, drawn.low.y + 1.3 * size}, size, name);
}

void drawHome(Markup& svg, const io::HomePlan& home, const Fit& fit, double nameSize) {
  svg.open("g", {{"class", "home"}});
  for (const char* kind : {"floor", "wall"})
    for (const io::HomeRoom& room : home.rooms) {
      Path outline;
      for (std::size_t i = 0; i < room.polygon.size(); ++i) {
        const Point at = fit({room.polygon[i].x, room.polygon[i].y});
        i == 0 ? outline.move(at.x, at.y) : outline.line(at.x, at.y);
      }
      svg.leaf("path", {{"class", kind}, {"d", outline.close().str()}});
    }
  for (const io::HomeOpening& door : home.doors) drawOpening(svg, "door", door, fit);
  for (const io::HomeOpening& window : home.windows) drawOpening(svg, "window", window, fit);
  if (nameSize > 0)
    for (const io::HomeRoom& room : home.rooms) drawName(svg, room, fit, nameSize);
  svg.close();
}

}  // namespace

FloorPlan readFloorPlan(const std::filesystem::path& path, const std::array<double, 4>& extent) {
  FloorPlan plan{{}, extent[0], extent[1], extent[2], extent[3]};
  constexpr double least = 0.01;  // [m] less than that is no building
  const bool isNear = Pose::planar(plan.xMin, plan.yMin, 0).isPlausible() &&
                      Pose::planar(plan.xMax, plan.yMax, 0).isPlausible();
  if (!isNear || plan.xMax - plan.xMin < least || plan.yMax - plan.yMin < least)
    throw Error(
        ErrorCode::invalidOption,
        "the floor plan's extent must be xMin, yMin, xMax, yMax in meters, within 10 000 km, at least "
        "0.01 m wide and high");
  constexpr std::size_t limit = 8'000'000;
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(ErrorCode::fileUnreadable, "cannot read the floor plan {}; check the path", path.string());
  plan.image.resize(limit + 1);
  file.read(reinterpret_cast<char*>(plan.image.data()), static_cast<std::streamsize>(plan.image.size()));
  plan.image.resize(static_cast<std::size_t>(file.gcount()));
  if (plan.image.size() > limit)
    fail(ErrorCode::tooLarge, "the floor plan {} is larger than 8 MB; reduce it", path.string());
  imageUri(plan.image, path.string());  // checks the format
  return plan;
}

FloorPlan readHomeFloorPlan(const std::filesystem::path& path) {
  FloorPlan plan;
  plan.home = std::make_shared<io::HomePlan>(
      io::readHomePlan(std::filesystem::is_directory(path) ? path / "home.json" : path));
  Extent extent;
  for (const io::HomeRoom& room : plan.home->rooms)
    for (const cv::Point2f& corner : room.polygon) extent.add({corner.x, corner.y});
  plan.xMin = extent.low.x, plan.yMin = extent.low.y, plan.xMax = extent.high.x, plan.yMax = extent.high.y;
  return plan;
}

namespace report {

void drawFloorPlan(Markup& svg, const FloorPlan& plan, const Fit& fit, double nameSize) {
  plan.home ? drawHome(svg, *plan.home, fit, nameSize) : drawImage(svg, plan, fit);
}

std::vector<Point> cornersOf(const FloorPlan& plan) {
  return {{plan.xMin, plan.yMin}, {plan.xMax, plan.yMax}};
}

void requireFitting(const FloorPlan& plan, const std::vector<std::optional<Point>>& frames) {
  std::size_t posed = 0, inside = 0;
  for (const auto& frame : frames) {
    if (!frame) continue;
    ++posed;
    inside += plan.home && io::roomAt(*plan.home, frame->x, frame->y) ? 1 : 0;
  }
  if (posed == 0)
    throw Error(ErrorCode::insufficientData,
                "a floor plan needs frames with poses, and none has one; leave the floor plan out");
  if (!plan.home) return;
  if (2 * inside < posed)
    fail(
        ErrorCode::mismatch,
        "only {} of {} frames lie in rooms of the floor plan; its coordinates [m] must be those of the map's "
        "poses",
        inside, posed);
}

}  // namespace report
}  // namespace estancia
