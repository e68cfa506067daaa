// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/world_store.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estancia/core/error.hpp"
#include "estancia/core/png.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store_read.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/world_file/area_names.hpp"

namespace estancia {
namespace {

using sqlite::Database;
using sqlite::Statement;

constexpr const char* tables = R"sql(
CREATE TABLE IF NOT EXISTS observations(frame INTEGER PRIMARY KEY, seen BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS zones(id INTEGER PRIMARY KEY, name TEXT NOT NULL, frames INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS frame_zones(frame INTEGER PRIMARY KEY, zone INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS floor(id INTEGER PRIMARY KEY, cell REAL NOT NULL,
    first_column INTEGER NOT NULL, first_row INTEGER NOT NULL, columns INTEGER NOT NULL, rows INTEGER NOT NULL,
    up_x REAL NOT NULL, up_y REAL NOT NULL, up_z REAL NOT NULL, areas BLOB NOT NULL, walls BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS areas(id INTEGER PRIMARY KEY, name TEXT NOT NULL, size REAL NOT NULL,
    x REAL NOT NULL, y REAL NOT NULL, frames INTEGER NOT NULL, outline TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS frame_areas(frame INTEGER PRIMARY KEY, area INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS area_edits(id INTEGER PRIMARY KEY, kind TEXT NOT NULL, x REAL NOT NULL,
    y REAL NOT NULL, to_x REAL NOT NULL, to_y REAL NOT NULL, name TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS object_edits(id INTEGER PRIMARY KEY, kind TEXT NOT NULL, x REAL NOT NULL,
    y REAL NOT NULL, z REAL NOT NULL, size_x REAL NOT NULL, size_y REAL NOT NULL, size_z REAL NOT NULL,
    name TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS objects(id INTEGER PRIMARY KEY, name TEXT NOT NULL, given_name TEXT NOT NULL,
    probability REAL NOT NULL, x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL, size_x REAL NOT NULL,
    size_y REAL NOT NULL, size_z REAL NOT NULL, yaw REAL NOT NULL, red INTEGER NOT NULL,
    green INTEGER NOT NULL, blue INTEGER NOT NULL, flat INTEGER NOT NULL, views INTEGER NOT NULL,
    first_frame INTEGER NOT NULL, last_frame INTEGER NOT NULL, best_frame INTEGER NOT NULL,
    support TEXT NOT NULL, on_object INTEGER, area INTEGER);
CREATE TABLE IF NOT EXISTS object_words(object INTEGER NOT NULL, label INTEGER NOT NULL,
    probability REAL NOT NULL, PRIMARY KEY(object, label)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS object_classes(object INTEGER NOT NULL, class TEXT NOT NULL,
    probability REAL NOT NULL, PRIMARY KEY(object, class)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS object_views(frame INTEGER NOT NULL, segment INTEGER NOT NULL, object INTEGER,
    quality REAL NOT NULL, words BLOB NOT NULL, jpeg BLOB NOT NULL, PRIMARY KEY(frame, segment));
CREATE INDEX IF NOT EXISTS views_of_object ON object_views(object, quality);
CREATE TABLE IF NOT EXISTS segment_words(frame INTEGER NOT NULL, segment INTEGER NOT NULL,
    words BLOB NOT NULL, PRIMARY KEY(frame, segment)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS object_segments(frame INTEGER NOT NULL, segment INTEGER NOT NULL,
    object INTEGER NOT NULL, PRIMARY KEY(frame, segment)) WITHOUT ROWID;
)sql";

constexpr std::array<const char*, 3> kinds{"name", "merge", "split"};
constexpr std::int64_t maxCells = 64'000'000;
/// Far beyond what `areas.cell` may be: a search as wide as a robot in cells narrower than these has no end.
constexpr double narrowestCell = 1e-3, widestCell = 1e3;  // [m]

/// An image of exactly this size and type. `what` names it.
cv::Mat imageOf(const Database& database, std::span<const std::byte> png, cv::Size size, int type,
                const char* what) {
  const cv::Mat image = fromPng({reinterpret_cast<const unsigned char*>(png.data()), png.size()}, size);
  if (image.size() != size || image.type() != type) database.failDamaged("{} cannot be decoded", what);
  return image;
}

std::string outlineText(const Area& area) {
  auto points = nlohmann::json::array();
  for (const cv::Point2d& corner : area.outline)
    points.push_back({std::round(corner.x * 1000) / 1000, std::round(corner.y * 1000) / 1000});
  return points.dump();
}

std::vector<cv::Point2d> outlineFrom(const Database& database, const std::string& text) {
  std::vector<cv::Point2d> outline;
  try {
    for (const auto& point : nlohmann::json::parse(text))
      outline.emplace_back(point.at(0).get<double>(), point.at(1).get<double>());
  } catch (const nlohmann::json::exception&) {
    database.failDamaged("the outline of an area is damaged");
  }
  return outline;
}

Observation decodedObservation(const Database& database, const std::string& bytes) {
  try {
    return observationFromBytes(bytes);
  } catch (const Error& e) {
    database.failDamaged("{}", e.what());
  }
}

/// A number below `end` of each frame of the map.
void readNumbers(Database& database, const char* column, const char* table, const TopologicalMap& map,
                 std::size_t end, std::vector<int>& numbers) {
  const auto frames = static_cast<std::int64_t>(frameCountOf(database));
  const FrameRows which(database, map);
  Statement rows = which.select(database, fmt::format("frame, {}", column), table, "frame");
  while (rows.next()) {
    const std::int64_t frame = rows.integer(0), number = rows.integer(1);
    if (frame < 0 || frame >= frames || number < 0 || number >= static_cast<std::int64_t>(end))
      database.failDamaged("a frame is in an area or a zone that is missing");
    if (const auto index = map.findFrame(static_cast<std::size_t>(frame)))
      numbers[*index] = static_cast<int>(number);
  }
}

/// Reads the plan from `floor`, or from its earlier version; nothing where the map has no plan.
std::optional<AreaPlan> readPlan(const Database& database, const char* table = "floor") {
  Statement row(
      database,
      fmt::format(
          "SELECT cell, first_column, first_row, columns, rows, up_x, up_y, up_z, areas, walls FROM {}",
          table));
  if (!row.next()) return std::nullopt;
  const double cell = row.finite(0, "the width of a cell");
  std::array<std::int64_t, 4> extent{};
  for (int i = 0; i < 4; ++i) extent[static_cast<std::size_t>(i)] = row.integer(i + 1);
  const auto& [column, line, columns, rows] = extent;
  const cv::Vec3d up(row.finite(5, "the floor"), row.finite(6, "the floor"), row.finite(7, "the floor"));
  if (cell < narrowestCell || cell > widestCell || columns < 1 || rows < 1 || columns > maxCells ||
      rows > maxCells || columns * rows > maxCells || std::abs(column) > 100'000'000 ||
      std::abs(line) > 100'000'000 || !(cv::norm(up) > 0.1))
    database.failDamaged("its floor plan has no size");
  const cv::Rect place(static_cast<int>(column), static_cast<int>(line), static_cast<int>(columns),
                       static_cast<int>(rows));
  AreaPlan plan{{}, Floor(up), FloorCells(cell, place), {}, {}};
  imageOf(database, row.bytes(8), place.size(), CV_16U, "the plan of areas").convertTo(plan.areaOf, CV_32S);
  plan.areaOf -= 1;
  plan.walls = imageOf(database, row.bytes(9), place.size(), CV_8U, "the plan of walls");
  return plan;
}

}  // namespace

WorldStore::WorldStore(MapStore& store, MapStore::Access access) : store_(store) {
  if (access == MapStore::Access::write)
    store_.database().run(tables);
  else
    exists_ = sqlite::hasTable(store_.database(), "area_edits");
}

void WorldStore::putLayers(const std::string& layers) {
  store_.database().execute("INSERT OR REPLACE INTO meta VALUES('layers', ?1)", layers);
}

void WorldStore::putZones(const Zones& zones) {
  Database& database = store_.database();
  const std::vector<std::size_t> frames = store_.frameNumbers();
  std::map<std::size_t, std::size_t> before;
  {
    Statement rows(database, "SELECT frame, zone FROM frame_zones WHERE frame >= 0 AND zone >= 0");
    while (rows.next())
      before.emplace(static_cast<std::size_t>(rows.integer(0)), static_cast<std::size_t>(rows.integer(1)));
  }
  GroupOverlap overlap;
  // Zones that earlier drives have found keep their numbers.
  const std::vector<Drive> drives = store_.drives();
  const std::size_t firstNow = drives.empty() ? 0 : drives.back().firstFrame;
  for (std::size_t i = 0; i < zones.zoneOf.size() && frames.at(i) < firstNow; ++i)
    if (const auto known = before.find(frames[i]); zones.zoneOf[i] >= 0 && known != before.end())
      ++overlap[{static_cast<std::size_t>(zones.zoneOf[i]), known->second}];
  const std::vector<std::size_t> numbers = keptNumbers(zones.zones.size(), overlap);
  const auto numberOf = [&](int zone) { return numbers.at(static_cast<std::size_t>(zone)); };
  database.run("DELETE FROM zones; DELETE FROM frame_zones");
  for (const Zone& zone : zones.zones)
    database.execute("INSERT INTO zones VALUES(?1, ?2, ?3)", numberOf(zone.id), zone.name,
                     zone.images.size());
  Statement row(database, "INSERT INTO frame_zones VALUES(?1, ?2)");
  for (std::size_t i = 0; i < zones.zoneOf.size(); ++i) {
    if (zones.zoneOf[i] < 0) continue;
    row.executeWith(frames.at(i), numberOf(zones.zoneOf[i]));
  }
}

void WorldStore::putObservation(std::size_t frame, const Observation& observation) {
  const std::string bytes = toBytes(observation);
  store_.database().execute("INSERT OR REPLACE INTO observations VALUES(?1, ?2)", frame,
                            std::as_bytes(std::span(bytes)));
}

void WorldStore::putAreas(const PlannedFrames& planned, const PlannedFrames* before) {
  Database& database = store_.database();
  database.run("DELETE FROM floor; DELETE FROM areas");
  const AreaPlan& plan = planned.plan;
  cv::Mat numbers;
  cv::Mat(plan.areaOf + 1).convertTo(numbers, CV_16U);
  const std::vector<unsigned char> image = toPng(numbers), walls = toPng(plan.walls);
  const cv::Rect& extent = plan.cells.extent();
  const cv::Vec3d& up = plan.floor.up();
  database.execute("INSERT INTO floor VALUES(0, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)", plan.cells.cell(),
                   extent.x, extent.y, extent.width, extent.height, up[0], up[1], up[2],
                   std::as_bytes(std::span(image)), std::as_bytes(std::span(walls)));
  for (const Area& area : plan.areas) {
    const std::string outline = outlineText(area);
    database.execute("INSERT INTO areas VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7)", area.id, area.name, area.size,
                     area.center.x, area.center.y, area.frames, outline);
  }
  putFrameAreas(planned, before);
}

void WorldStore::putFrameAreas(const PlannedFrames& planned, const PlannedFrames* before) {
  Database& database = store_.database();
  const std::vector<std::size_t>& frames = planned.frames;
  const std::vector<int>& areas = planned.areaOfFrame;
  const std::size_t end = before && !frames.empty() ? frames.back() + 1 : 0;
  database.execute("DELETE FROM frame_areas WHERE frame >= ?1", end);
  Statement row(database, "INSERT OR REPLACE INTO frame_areas VALUES(?1, ?2)");
  Statement nowhere(database, "DELETE FROM frame_areas WHERE frame = ?1");
  for (std::size_t i = 0, k = 0; i < areas.size(); ++i) {
    while (before && k < before->frames.size() && before->frames[k] < frames[i]) ++k;
    const bool isKnown = before && k < before->frames.size() && before->frames[k] == frames[i];
    if (isKnown && before->areaOfFrame[k] == areas[i]) continue;
    if (areas[i] < 0)
      nowhere.executeWith(frames[i]);
    else
      row.executeWith(frames[i], areas[i]);
  }
}

void WorldStore::keepPlanBefore() {
  store_.database().run(
      "DROP TABLE IF EXISTS floor_before; CREATE TABLE floor_before AS SELECT * FROM floor");
}

std::optional<AreaPlan> WorldStore::planBefore() const {
  if (!sqlite::hasTable(store_.database(), "floor_before")) return std::nullopt;
  return readPlan(store_.database(), "floor_before");
}

void WorldStore::forgetAreasOfMissingFrames() {
  store_.database().run("DELETE FROM frame_areas WHERE frame NOT IN (SELECT id FROM frames)");
}

void WorldStore::dropObservation(std::size_t frame) {
  store_.database().execute("DELETE FROM observations WHERE frame = ?1", frame);
}

void WorldStore::addEdit(const AreaEdit& edit) {
  store_.database().execute(
      "INSERT INTO area_edits(kind, x, y, to_x, to_y, name) VALUES(?1, ?2, ?3, ?4, ?5, ?6)",
      kinds[static_cast<std::size_t>(edit.kind)], edit.from.x, edit.from.y, edit.to.x, edit.to.y, edit.name);
}

std::string WorldStore::layers() const {
  Statement row(store_.database(), "SELECT value FROM meta WHERE key = 'layers'");
  return row.next() ? row.text(0) : "";
}

void WorldStore::forEachObservation(
    const std::function<bool(std::size_t frame, const Observation&)>& visit) const {
  if (!exists_) return;
  // The next frame's observation comes before the frame itself.
  const auto last = static_cast<std::int64_t>(store_.frameCount());
  Statement rows(store_.database(), "SELECT frame, seen FROM observations ORDER BY frame");
  while (rows.next()) {
    if (rows.integer(0) < 0 || rows.integer(0) > last)
      store_.database().failDamaged("an observation is of no frame");
    if (!visit(static_cast<std::size_t>(rows.integer(0)),
               decodedObservation(store_.database(), rows.blob(1))))
      return;
  }
}

std::vector<std::size_t> WorldStore::observedFrames() const {
  return store_.database().numbers("SELECT frame FROM observations WHERE frame >= 0 ORDER BY frame");
}

Observation WorldStore::observation(std::size_t frame) const {
  Statement row(store_.database(), "SELECT seen FROM observations WHERE frame = ?1", frame);
  if (!row.next()) store_.database().failDamaged("an observation is missing");
  return decodedObservation(store_.database(), row.blob(0));
}

std::vector<AreaEdit> WorldStore::edits() const {
  std::vector<AreaEdit> edits;
  if (!exists_) return edits;
  const Database& database = store_.database();
  Statement rows(database, "SELECT kind, x, y, to_x, to_y, name FROM area_edits ORDER BY id");
  while (rows.next()) {
    const auto kind = std::find(kinds.begin(), kinds.end(), rows.text(0));
    if (kind == kinds.end()) database.failDamaged("an edit of areas is of no kind");
    edits.push_back({static_cast<AreaEdit::Kind>(kind - kinds.begin()),
                     {rows.finite(1, "an edit"), rows.finite(2, "an edit")},
                     {rows.finite(3, "an edit"), rows.finite(4, "an edit")},
                     printable(rows.text(5))});
  }
  return edits;
}

void WorldStore::read(WorldMap& world) const {
  world.areaOfFrame.assign(world.places.frames.size(), -1);
  world.zoneOfFrame.assign(world.places.frames.size(), -1);
  if (!exists_) return;
  readZones(world);
  world.edits = edits();
  world.plan = readPlan(store_.database());
  if (world.plan) readAreas(world);
  nameAreasByRooms(world);
  readObjects(world);
}

void WorldStore::readZones(WorldMap& world) const {
  Database& database = store_.database();
  Statement rows(database, "SELECT id, name, frames FROM zones ORDER BY id");
  while (rows.next()) {
    if (rows.integer(0) != static_cast<std::int64_t>(world.zones.size()) || rows.integer(2) < 0)
      database.failDamaged("its zones have gaps");
    world.zones.push_back({static_cast<int>(world.zones.size()), printable(rows.text(1)),
                           static_cast<std::size_t>(rows.integer(2))});
  }
  readNumbers(database, "zone", "frame_zones", world.places, world.zones.size(), world.zoneOfFrame);
}

void WorldStore::readAreas(WorldMap& world) const {
  Database& database = store_.database();
  Statement rows(database, "SELECT id, name, size, x, y, frames, outline FROM areas ORDER BY id");
  while (rows.next()) {
    WorldArea area;
    area.id = static_cast<int>(world.areas.size());
    if (rows.integer(0) != area.id) database.failDamaged("its areas have gaps");
    area.name = printable(rows.text(1));
    area.size = rows.finite(2, "an area's size");
    area.center = {rows.finite(3, "an area's center"), rows.finite(4, "an area's center")};
    area.frames = static_cast<std::size_t>(std::max<std::int64_t>(0, rows.integer(5)));
    area.outline = outlineFrom(database, rows.text(6));
    world.plan->areas.push_back(area);
    world.areas.push_back(std::move(area));
  }
  double most = -1;
  cv::minMaxLoc(world.plan->areaOf, nullptr, &most);
  if (most >= static_cast<double>(world.areas.size())) database.failDamaged("its plan has unknown areas");
  readNumbers(database, "area", "frame_areas", world.places, world.areas.size(), world.areaOfFrame);
  for (const AreaEdit& edit : world.edits)
    if (edit.kind == AreaEdit::Kind::name)
      if (const int area = areaAt(*world.plan, edit.from, 1); area >= 0)
        world.areas[static_cast<std::size_t>(area)].givenName = edit.name;
}

}  // namespace estancia
