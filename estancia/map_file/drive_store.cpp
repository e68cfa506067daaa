// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/drive_store.hpp"

#include <fmt/format.h>

#include <limits>

#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store_read.hpp"

namespace estancia {

using sqlite::Statement;

const char* const schemaOfDrives = R"sql(
CREATE TABLE IF NOT EXISTS drives(first_frame INTEGER PRIMARY KEY, name TEXT NOT NULL,
                                  fingerprint TEXT NOT NULL, aligned INTEGER NOT NULL, x REAL, y REAL, z REAL, qx REAL, qy REAL, qz REAL,
                                  qw REAL);
CREATE TABLE IF NOT EXISTS given_poses(frame INTEGER PRIMARY KEY, x REAL, y REAL, z REAL, qx REAL, qy REAL,
                                       qz REAL, qw REAL);
)sql";

void DriveStore::put(const Drive& drive) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();  // stored as NULL
  const Pose p = drive.alignment.value_or(Pose{none, none, none, none, none, none, none});
  Statement(store_.database(),
            "INSERT OR REPLACE INTO drives VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
            drive.firstFrame, drive.name, drive.fingerprint, drive.isAligned ? 1 : 0, p.x, p.y, p.z, p.qx,
            p.qy, p.qz, p.qw)
      .execute();
}

void DriveStore::putGivenPose(std::size_t frame, const Pose& p) {
  Statement(store_.database(), "INSERT OR REPLACE INTO given_poses VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
            frame, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw)
      .execute();
}

std::vector<Drive> DriveStore::drives() const {
  return readDrives(store_.database());
}

bool DriveStore::hasPoses() const {
  return store_.database().number("SELECT EXISTS(SELECT 1 FROM frames WHERE x IS NOT NULL)") != 0;
}

std::optional<Pose> DriveStore::givenPose(std::size_t frame) const {
  if (!sqlite::hasTable(store_.database(), "given_poses")) return std::nullopt;
  Statement row(store_.database(), "SELECT x, y, z, qx, qy, qz, qw FROM given_poses WHERE frame = ?1", frame);
  if (!row.next()) return std::nullopt;
  const std::optional<Pose> pose = readPose(row, 0);
  if (!pose) store_.database().failDamaged(fmt::format("the given pose of frame {} is none", frame));
  return pose;
}

}  // namespace estancia
