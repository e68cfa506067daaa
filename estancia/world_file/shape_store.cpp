// SPDX-License-Identifier: Apache-2.0
#include "estancia/world_file/shape_store.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "estancia/core/printable.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store_read.hpp"

namespace estancia {
namespace {

using sqlite::Database;
using sqlite::Statement;

constexpr const char* shapeTables = R"sql(
CREATE TABLE IF NOT EXISTS shape_classes(id INTEGER PRIMARY KEY, name TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS segment_shapes(frame INTEGER NOT NULL, segment INTEGER NOT NULL,
    probabilities BLOB NOT NULL, PRIMARY KEY(frame, segment)) WITHOUT ROWID;
)sql";

}  // namespace

void ShapeStore::begin(const std::vector<std::string>& classes, const std::string& digest) {
  Database& database = store_.database();
  database.run(shapeTables);
  Statement kept(database, "SELECT value FROM meta WHERE key = 'object_model'");
  if (kept.next() && kept.text(0) == digest) return;
  database.run("DELETE FROM shape_classes; DELETE FROM segment_shapes");
  for (std::size_t i = 0; i < classes.size(); ++i)
    Statement(database, "INSERT INTO shape_classes VALUES(?1, ?2)", i, classes[i]).execute();
  Statement(database, "INSERT OR REPLACE INTO meta VALUES('object_model', ?1)", digest).execute();
}

void ShapeStore::put(const SegmentPlace& place, const std::vector<float>& probabilities) {
  Statement(store_.database(), "INSERT OR REPLACE INTO segment_shapes VALUES(?1, ?2, ?3)", place.first,
            place.second, std::span<const float>(probabilities))
      .execute();
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
