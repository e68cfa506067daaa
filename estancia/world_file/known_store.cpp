// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/known_store.hpp"

#include <limits>

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

}  // namespace

bool KnownStore::exists() const {
  return sqlite::hasTable(store_.database(), "object_poses");
}

void KnownStore::begin(const std::string& name, const std::string& digest) {
  Database& database = store_.database();
  database.run(knownTables);
  Statement known(database, "SELECT digest FROM known_objects WHERE name = ?1", name);
  if (known.next() && known.text(0) == digest) return;
  Statement(database, "DELETE FROM recognitions WHERE name = ?1", name).execute();
  Statement(database, "INSERT OR REPLACE INTO known_objects VALUES(?1, ?2)", name, digest).execute();
}

void KnownStore::put(const SegmentPlace& place, const SegmentRecognition& recognition) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();  // stored as NULL
  const Pose p = recognition.pose.value_or(Pose{none, none, none, none, none, none, none});
  Statement(store_.database(),
            "INSERT OR REPLACE INTO recognitions VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
            place.first, place.second, recognition.name, recognition.pose ? recognition.confidence : none,
            p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw)
      .execute();
}

void KnownStore::putPoses(std::span<const std::optional<KnownPose>> poses) {
  if (!exists()) return;
  Database& database = store_.database();
  database.run("DELETE FROM object_poses");
  Statement row(database, "INSERT INTO object_poses VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)");
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    const KnownPose& known = *poses[i];
    const Pose& p = known.pose;
    row.bindAll(i, known.name, known.confidence, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw, known.frame);
    row.execute();
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
    SegmentRecognition recognition{rows.text(2), readPose(rows, 4)};
    if (recognition.pose) recognition.confidence = confidenceOf(database, rows, 3);
    recognitions.emplace(SegmentPlace(rows.integer(0), rows.integer(1)), std::move(recognition));
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
    const std::optional<Pose> pose = readPose(rows, 3);
    if (object < 0 || object >= static_cast<std::int64_t>(world.objects.size()) || frame < 0 ||
        frame >= static_cast<std::int64_t>(store_.frameCount()) || !pose)
      database.failDamaged("a recognized object or its pose is missing");
    world.objects[static_cast<std::size_t>(object)].known =
        KnownPose{printable(rows.text(1)), confidenceOf(database, rows, 2), *pose,
                  world.places.indexOf(static_cast<std::size_t>(frame))};
  }
}

}  // namespace estancia
