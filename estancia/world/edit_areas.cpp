// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/edit_areas.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/topology/store.hpp"
#include "estancia/world/area_names.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world/world_store.hpp"

namespace estancia {
namespace {

/// Keeps the edit and makes the areas again.
void correctAreas(const std::filesystem::path& map, const AreaEdit& edit) {
  const MapStore::Identity identity = MapStore::open(map, MapStore::Access::read).identity();
  MappingSession session = MappingSession::resume(map, identity.vocabulary, identity.model);
  WorldMapper mapper(session);
  mapper.correct(edit);
  mapper.finish();
}

}  // namespace

const WorldArea& getArea(const WorldMap& world, const std::string& area) {
  if (world.areas.empty())
    fail(ErrorCode::insufficientData,
         "the map has no areas; map a drive with depth (`estancia check` tells what is missing)");
  int id = -1;
  const auto [end, problem] = std::from_chars(area.data(), area.data() + area.size(), id);
  if (problem == std::errc{} && end == area.data() + area.size())
    if (const WorldArea* found = world.findArea(id)) return *found;
  const std::vector<int> called = areasCalled(world, area);
  if (called.size() == 1) return *world.findArea(called.front());
  std::vector<std::string> known;
  for (const WorldArea& candidate : world.areas)
    if (called.empty() || std::ranges::find(called, candidate.id) != called.end())
      known.push_back(fmt::format("{} ({})", candidate.id, candidate.displayName()));
  if (!called.empty())
    fail(ErrorCode::unknownName, "the map has several areas \"{}\": {}; give the number of one",
         printable(area), fmt::join(known, ", "));
  fail(ErrorCode::unknownName, "the map has no area \"{}\"; it has {}", printable(area),
       fmt::join(known, ", "));
}

void nameArea(const std::filesystem::path& map, const std::string& area, const std::string& name) {
  const WorldMap world = readWorld(map);
  const AreaEdit edit{AreaEdit::Kind::name, getArea(world, area).center, {}, name};
  MapStore store = MapStore::open(map, MapStore::Access::write);
  WorldStore(store, MapStore::Access::write).addEdit(edit);
  store.commit();
}

void mergeAreas(const std::filesystem::path& map, const std::string& area, const std::string& other) {
  const WorldMap world = readWorld(map);
  const WorldArea &one = getArea(world, area), &two = getArea(world, other);
  if (one.id == two.id)
    fail(ErrorCode::invalidInput, "\"{}\" and \"{}\" are one area; give two", printable(area),
         printable(other));
  correctAreas(map, {AreaEdit::Kind::merge, one.center, two.center, ""});
}

void splitArea(const std::filesystem::path& map, const cv::Point2d& from, const cv::Point2d& to) {
  const WorldMap world = readWorld(map);
  if (world.areas.empty()) getArea(world, "");
  const auto where = [](const cv::Point2d& at) { return fmt::format("({:.2f}, {:.2f})", at.x, at.y); };
  const cv::Point2d middle = (from + to) / 2;
  const int area = areaAt(*world.plan, middle, world.plan->cells.cell());
  if (area < 0)
    fail(ErrorCode::invalidInput, "{} m, the middle of the line, is in no area; give two points across one",
         where(middle));
  bool left = false, right = false;
  const cv::Mat& areas = world.plan->areaOf;
  for (int row = 0; row < areas.rows; ++row)
    for (int column = 0; column < areas.cols; ++column)
      if (areas.at<int>(row, column) == area)
        ((to - from).cross(world.plan->cells.centerOf({column, row}) - from) > 0 ? left : right) = true;
  if (!left || !right)
    fail(ErrorCode::invalidInput,
         "the line from {} to {} m does not cross area {}; give two points across it", where(from), where(to),
         area);
  correctAreas(map, {AreaEdit::Kind::split, from, to, ""});
}

}  // namespace estancia
