// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/segment_answers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/core/printable.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store_read.hpp"

namespace estancia {
namespace {

using sqlite::Database;
using sqlite::Statement;

constexpr const char* knownTables = R"sql(
CREATE TABLE IF NOT EXISTS known_objects(name TEXT PRIMARY KEY, digest TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS recognitions(frame INTEGER NOT NULL, segment INTEGER NOT NULL, name TEXT NOT NULL,
    confidence REAL, x REAL, y REAL, z REAL, qx REAL, qy REAL, qz REAL, qw REAL,
    PRIMARY KEY(frame, segment, name)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS object_poses(object INTEGER PRIMARY KEY, name TEXT NOT NULL,
    confidence REAL NOT NULL, x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL, qx REAL NOT NULL,
    qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL, frame INTEGER NOT NULL);
)sql";

double confidenceOf(const Database& database, const Statement& row, int column) {
  const double confidence = row.real(column);
  if (!(confidence >= 0 && confidence <= 1))
    database.failDamaged("the confidence of a recognized object is no probability");
  return confidence;
}

constexpr const char* shapeTables = R"sql(
CREATE TABLE IF NOT EXISTS shape_classes(id INTEGER PRIMARY KEY, name TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS segment_shapes(frame INTEGER NOT NULL, segment INTEGER NOT NULL,
    probabilities BLOB NOT NULL, PRIMARY KEY(frame, segment)) WITHOUT ROWID;
)sql";

}  // namespace

bool KnownStore::exists() const {
  return sqlite::hasTable(store_.database(), "object_poses");
}

void KnownStore::begin(const std::string& name, const std::string& digest) {
  Database& database = store_.database();
  database.run(knownTables);
  Statement known(database, "SELECT digest FROM known_objects WHERE name = ?1", name);
  if (known.next() && known.text(0) == digest) return;
  database.execute("DELETE FROM recognitions WHERE name = ?1", name);
  database.execute("INSERT OR REPLACE INTO known_objects VALUES(?1, ?2)", name, digest);
}

void KnownStore::put(const SegmentPlace& place, const SegmentRecognition& recognition) {
  store_.database().execute(
      "INSERT OR REPLACE INTO recognitions VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)", place.first,
      place.second, recognition.name, recognition.confidence, recognition.pose);
}

void KnownStore::putPoses(std::span<const std::optional<KnownPose>> poses) {
  if (!exists()) return;
  Database& database = store_.database();
  database.run("DELETE FROM object_poses");
  Statement row(database, "INSERT INTO object_poses VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)");
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    const KnownPose& known = *poses[i];
    row.executeWith(i, known.name, known.confidence, known.pose, known.frame);
  }
}

std::multimap<SegmentPlace, SegmentRecognition> KnownStore::recognitions() const {
  std::multimap<SegmentPlace, SegmentRecognition> recognitions;
  if (!exists()) return recognitions;
  const Database& database = store_.database();
  Statement rows(database,
                 "SELECT frame, segment, name, confidence, x, y, z, qx, qy, qz, qw FROM recognitions "
                 "ORDER BY frame, segment, name");
  while (rows.next()) {
    if (rows.integer(0) < 0 || rows.integer(1) < 0)
      database.failDamaged("an object was recognized in no frame");
    recognitions.emplace(SegmentPlace(rows.integer(0), rows.integer(1)),
                         SegmentRecognition{rows.text(2), rows.pose(4), confidenceOf(database, rows, 3)});
  }
  return recognitions;
}

void KnownStore::read(WorldMap& world) const {
  if (!exists()) return;
  const Database& database = store_.database();
  Statement rows(database,
                 "SELECT object, name, confidence, x, y, z, qx, qy, qz, qw, frame FROM object_poses");
  while (rows.next()) {
    const std::int64_t object = rows.integer(0), frame = rows.integer(10);
    const std::optional<Pose> pose = rows.pose(3);
    if (object < 0 || object >= static_cast<std::int64_t>(world.objects.size()) || frame < 0 ||
        frame >= static_cast<std::int64_t>(store_.frameCount()) || !pose)
      database.failDamaged("a recognized object or its pose is missing");
    world.objects[static_cast<std::size_t>(object)].known =
        KnownPose{printable(rows.text(1)), confidenceOf(database, rows, 2), *pose,
                  world.places.indexOf(static_cast<std::size_t>(frame))};
  }
}

void ShapeStore::begin(const std::vector<std::string>& classes, const std::string& digest) {
  Database& database = store_.database();
  database.run(shapeTables);
  Statement kept(database, "SELECT value FROM meta WHERE key = 'object_model'");
  if (kept.next() && kept.text(0) == digest) return;
  database.run("DELETE FROM shape_classes; DELETE FROM segment_shapes");
  for (std::size_t i = 0; i < classes.size(); ++i)
    database.execute("INSERT INTO shape_classes VALUES(?1, ?2)", i, classes[i]);
  database.execute("INSERT OR REPLACE INTO meta VALUES('object_model', ?1)", digest);
}

void ShapeStore::put(const SegmentPlace& place, const std::vector<float>& probabilities) {
  store_.database().execute("INSERT OR REPLACE INTO segment_shapes VALUES(?1, ?2, ?3)", place.first,
                            place.second, std::span<const float>(probabilities));
}

std::vector<std::string> ShapeStore::classes() const {
  std::vector<std::string> classes;
  const Database& database = store_.database();
  if (!sqlite::hasTable(database, "shape_classes")) return classes;
  Statement rows(database, "SELECT id, name FROM shape_classes ORDER BY id");
  while (rows.next()) {
    if (rows.integer(0) != static_cast<std::int64_t>(classes.size()))
      database.failDamaged("its classes of shapes have gaps");
    classes.push_back(printable(rows.text(1)));
  }
  return classes;
}

std::map<SegmentPlace, std::vector<float>> ShapeStore::probabilities() const {
  std::map<SegmentPlace, std::vector<float>> shapes;
  const Database& database = store_.database();
  if (!sqlite::hasTable(database, "segment_shapes")) return shapes;
  const std::size_t count = classes().size();
  Statement rows(database,
                 "SELECT frame, segment, probabilities FROM segment_shapes ORDER BY frame, segment");
  while (rows.next()) {
    if (rows.integer(0) < 0 || rows.integer(1) < 0) database.failDamaged("a shape is of no frame");
    std::vector<float> probabilities;
    if (const auto bytes = rows.bytes(2); !bytes.empty())
      readValues(database, bytes, count, "the shape of a segment", probabilities);
    if (!std::ranges::all_of(probabilities, [](float p) { return p >= 0 && p <= 1; }))
      database.failDamaged("the shape of a segment has no probabilities");
    shapes.emplace(SegmentPlace(rows.integer(0), rows.integer(1)), std::move(probabilities));
  }
  return shapes;
}

}  // namespace estancia
