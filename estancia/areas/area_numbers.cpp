// SPDX-License-Identifier: Apache-2.0
#include "estancia/areas/area_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "estancia/areas/plan_areas.hpp"
#include "estancia/stats/kept_numbers.hpp"

namespace estancia {
namespace {

constexpr double sameFloor = std::numbers::pi / 180;  // directions of up that differ by less [rad]

bool haveOneGrid(const AreaPlan& a, const AreaPlan& b) {
  return a.cells.cell() == b.cells.cell() &&
         std::acos(std::clamp(a.floor.up().dot(b.floor.up()), -1.0, 1.0)) < sameFloor;
}

/// Cells that an area has in common with one of before.
GroupOverlap overlapOf(const AreaPlan& now, const AreaPlan& before) {
  GroupOverlap overlap;
  const cv::Rect common = now.cells.extent() & before.cells.extent();
  for (int y = common.y; y < common.y + common.height; ++y)
    for (int x = common.x; x < common.x + common.width; ++x) {
      const int area = now.areaOf.at<int>(y - now.cells.extent().y, x - now.cells.extent().x);
      const int known = before.areaOf.at<int>(y - before.cells.extent().y, x - before.cells.extent().x);
      if (area >= 0 && known >= 0)
        ++overlap[{static_cast<std::size_t>(area), static_cast<std::size_t>(known)}];
    }
  return overlap;
}

}  // namespace

void keepNumbers(PlannedFrames& planned, const AreaPlan& before) {
  AreaPlan& plan = planned.plan;
  if (!haveOneGrid(plan, before)) return;
  const std::vector<std::size_t> numbers = keptNumbers(plan.areas.size(), overlapOf(plan, before));
  std::vector<Area> areas(plan.areas.size());
  for (std::size_t i = 0; i < plan.areas.size(); ++i) {
    areas[numbers[i]] = std::move(plan.areas[i]);
    areas[numbers[i]].id = static_cast<int>(numbers[i]);
  }
  plan.areas = std::move(areas);
  const auto renumber = [&numbers](int& area) {
    if (area >= 0) area = static_cast<int>(numbers[static_cast<std::size_t>(area)]);
  };
  plan.areaOf.forEach<int>([&](int& area, const int*) { renumber(area); });
  std::ranges::for_each(planned.areaOfFrame, renumber);
}

}  // namespace estancia
