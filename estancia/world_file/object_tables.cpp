// The tables of objects: what WorldStore reads and writes of them.
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>

#include "estancia/core/bytes.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store_read.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_file/world_store.hpp"

namespace estancia {
namespace {

using sqlite::Database;
using sqlite::Statement;

constexpr const char* regionLabelsKey = "region-labels";
constexpr const char* putViewSql =
    "INSERT OR REPLACE INTO object_views(frame, segment, quality, words, jpeg) VALUES(?1, ?2, ?3, ?4, ?5)";
constexpr const char* putWordsSql = "INSERT OR REPLACE INTO segment_words VALUES(?1, ?2, ?3)";
constexpr std::array<const char*, 2> objectEditKinds{"name", "remove"};

}  // namespace

void WorldStore::putView(const LabeledSegment& view, std::span<const unsigned char> jpeg) {
  store_.database().execute(putViewSql, view.frame, view.segment, view.quality,
                            std::span<const float>(view.words), std::as_bytes(jpeg));
}

void WorldStore::copyViews(const WorldStore& from, std::span<const std::size_t> frames, std::size_t to) {
  if (!from.exists_ || frames.empty()) return;
  Database &source = from.store_.database(), &here = store_.database();
  const auto copy = [&](const char* query, const auto& put) {
    Statement row(source, query, frames.front(), frames.back());
    while (row.next()) {
      const auto number = static_cast<std::size_t>(row.integer(0));
      const auto found = std::ranges::lower_bound(frames, number);
      if (found != frames.end() && *found == number)
        put(to + static_cast<std::size_t>(found - frames.begin()), row);
    }
  };
  Statement putView(here, putViewSql), putWords(here, putWordsSql);
  copy("SELECT frame, segment, quality, words, jpeg FROM object_views WHERE frame BETWEEN ?1 AND ?2",
       [&](std::size_t frame, const Statement& view) {
         putView.executeWith(frame, view.integer(1), view.real(2), view.bytes(3), view.bytes(4));
       });
  if (!sqlite::hasTable(source, "segment_words")) return;
  copy("SELECT frame, segment, words FROM segment_words WHERE frame BETWEEN ?1 AND ?2",
       [&](std::size_t frame, const Statement& words) {
         putWords.executeWith(frame, words.integer(1), words.bytes(2));
       });
}

void WorldStore::putRegionLabels(const std::vector<std::size_t>& labels) {
  ByteWriter bytes;
  bytes.numbers(std::vector<std::uint32_t>(labels.begin(), labels.end()));
  store_.putState(regionLabelsKey, bytes.bytes());
}

std::vector<std::size_t> WorldStore::regionLabels() const {
  const std::optional<std::string> kept = store_.findState(regionLabelsKey);
  if (!kept) return {};
  try {
    ByteReader bytes(*kept, "the labels of its detector", "make the map anew");
    std::vector<std::size_t> labels;
    for (const std::uint32_t label : bytes.numbers<std::uint32_t>()) {
      if (label >= store_.identity().vocabulary.size()) bytes.fail("a label is missing");
      labels.push_back(label);
    }
    return labels;
  } catch (const Error& e) {
    store_.database().failDamaged("{}", e.what());
  }
}

void WorldStore::putSegmentWords(const SegmentPlace& place, const LexicalDescriptor& words) {
  store_.database().execute(putWordsSql, place.first, place.second, std::span<const float>(words));
}

void WorldStore::forEachSegmentWords(
    const std::function<void(const SegmentPlace&, const LexicalDescriptor&)>& visit) const {
  const std::size_t labels = regionLabels().size();
  if (!exists_ || labels == 0) return;
  Statement rows(store_.database(),
                 "SELECT frame, segment, words FROM segment_words ORDER BY frame, segment");
  LexicalDescriptor words;
  while (rows.next()) {
    if (rows.integer(0) < 0 || rows.integer(1) < 0)
      store_.database().failDamaged("words of a segment are of no frame");
    readValues(store_.database(), rows.bytes(2), labels, "the words of a segment", words);
    visit({static_cast<std::size_t>(rows.integer(0)), static_cast<std::size_t>(rows.integer(1))}, words);
  }
}

void WorldStore::putObjects(std::span<const WorldObject> objects,
                            const std::map<SegmentPlace, int>& objectOf) {
  Database& database = store_.database();
  database.run(
      "DELETE FROM objects; DELETE FROM object_words; DELETE FROM object_classes; "
      "DELETE FROM object_segments; UPDATE object_views SET object = NULL");
  const Vocabulary& vocabulary = store_.identity().vocabulary;
  std::unordered_map<std::string, std::size_t> numbers;
  for (std::size_t i = 0; i < vocabulary.size(); ++i) numbers.emplace(vocabulary[i], i);
  constexpr double none = std::numeric_limits<double>::quiet_NaN();  // stored as NULL
  Statement row(database,
                "INSERT INTO objects VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, "
                "?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22)");
  Statement word(database, "INSERT INTO object_words VALUES(?1, ?2, ?3)");
  Statement shape(database, "INSERT INTO object_classes VALUES(?1, ?2, ?3)");
  for (const WorldObject& object : objects) {
    const std::string name = object.displayName();
    row.executeWith(object.id, name, object.givenName, object.probability(), object.center.x, object.center.y,
                    object.center.z, object.size.x, object.size.y, object.size.z, object.yaw, object.color[0],
                    object.color[1], object.color[2], static_cast<int>(object.flat), object.views,
                    object.firstFrame, object.lastFrame, object.bestFrame,
                    supportNames[static_cast<std::size_t>(object.support)],
                    object.onObject < 0 ? none : object.onObject, object.area < 0 ? none : object.area);
    for (const LabelProbability& label : object.words)
      if (const auto number = numbers.find(label.label); number != numbers.end()) {
        word.executeWith(object.id, number->second, static_cast<double>(label.probability));
      }
    for (const LabelProbability& known : object.shapeClasses) {
      shape.executeWith(object.id, known.label, static_cast<double>(known.probability));
    }
  }
  Statement view(database, "UPDATE object_views SET object = ?3 WHERE frame = ?1 AND segment = ?2");
  Statement segment(database, "INSERT INTO object_segments VALUES(?1, ?2, ?3)");
  for (const auto& [place, object] : objectOf)
    for (Statement* statement : {&view, &segment}) statement->executeWith(place.first, place.second, object);
}

void WorldStore::putObjectAreas(std::span<const int> areas) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();  // stored as NULL
  Statement row(store_.database(), "UPDATE objects SET area = ?2 WHERE id = ?1");
  for (std::size_t i = 0; i < areas.size(); ++i) {
    row.executeWith(i, areas[i] < 0 ? none : areas[i]);
  }
}

std::vector<LabeledSegment> WorldStore::views() const {
  std::vector<LabeledSegment> views;
  if (!exists_) return views;
  const Database& database = store_.database();
  const std::size_t labels = store_.identity().vocabulary.size();
  Statement rows(database, "SELECT frame, segment, quality, words FROM object_views ORDER BY frame, segment");
  while (rows.next()) {
    if (rows.integer(0) < 0 || rows.integer(1) < 0)
      database.failDamaged("a view of an object is of no frame");
    LabeledSegment view{static_cast<std::size_t>(rows.integer(0)), static_cast<std::size_t>(rows.integer(1)),
                        rows.finite(2, "the quality of a view")};
    readValues(database, rows.bytes(3), labels, "the words of a view", view.words);
    views.push_back(std::move(view));
  }
  return views;
}

std::map<SegmentPlace, int> WorldStore::objectSegments() const {
  std::map<SegmentPlace, int> objectOf;
  if (!exists_ || !sqlite::hasTable(store_.database(), "object_segments")) return objectOf;
  const std::int64_t objects = store_.database().number("SELECT count(*) FROM objects");
  Statement rows(store_.database(), "SELECT frame, segment, object FROM object_segments");
  while (rows.next()) {
    if (rows.integer(0) < 0 || rows.integer(1) < 0 || rows.integer(2) < 0 || rows.integer(2) >= objects)
      store_.database().failDamaged("a segment is of no object");
    objectOf.emplace(SegmentPlace(rows.integer(0), rows.integer(1)), static_cast<int>(rows.integer(2)));
  }
  return objectOf;
}

std::vector<unsigned char> WorldStore::objectImage(int object) const {
  if (!exists_) return {};
  Statement row(store_.database(),
                "SELECT jpeg FROM object_views WHERE object = ?1 ORDER BY quality DESC, frame LIMIT 1",
                object);
  if (!row.next()) return {};
  const auto bytes = row.bytes(0);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  return {data, data + bytes.size()};
}

void WorldStore::addObjectEdit(const ObjectEdit& edit) {
  store_.database().execute(
      "INSERT INTO object_edits(kind, x, y, z, size_x, size_y, size_z, name) "
      "VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
      objectEditKinds[static_cast<std::size_t>(edit.kind)], edit.center.x, edit.center.y, edit.center.z,
      edit.size.x, edit.size.y, edit.size.z, edit.name);
}

std::vector<ObjectEdit> WorldStore::objectEdits() const {
  std::vector<ObjectEdit> edits;
  const Database& database = store_.database();
  if (!exists_ || !sqlite::hasTable(database, "object_edits")) return edits;
  Statement rows(database,
                 "SELECT kind, x, y, z, size_x, size_y, size_z, name FROM object_edits ORDER BY id");
  const auto number = [&](int column) { return rows.finite(column, "an edit of objects"); };
  while (rows.next()) {
    const auto kind = std::ranges::find(objectEditKinds, rows.text(0));
    if (kind == objectEditKinds.end()) database.failDamaged("an edit of objects is of no kind");
    edits.push_back({static_cast<ObjectEdit::Kind>(kind - objectEditKinds.begin()),
                     {number(1), number(2), number(3)},
                     {number(4), number(5), number(6)},
                     printable(rows.text(7))});
  }
  return edits;
}

std::vector<std::size_t> WorldStore::objectFrames() const {
  if (!exists_) return {};
  const Database& database = store_.database();
  std::string sql =
      "SELECT first_frame FROM objects UNION SELECT last_frame FROM objects UNION SELECT best_frame FROM "
      "objects";
  if (sqlite::hasTable(database, "object_poses")) sql += " UNION SELECT frame FROM object_poses";
  return database.numbers(sql);
}

void WorldStore::readObjects(WorldMap& world) const {
  const Database& database = store_.database();
  const auto frames = static_cast<std::int64_t>(store_.frameCount());
  const auto within = [&](const Statement& row, int column, std::int64_t end, const char* what) {
    const std::int64_t value = row.integer(column);
    if (value < 0 || value >= end) database.failDamaged("an object's {} is {}", what, value);
    return value;
  };
  Statement rows(
      database,
      "SELECT id, given_name, x, y, z, size_x, size_y, size_z, yaw, red, green, blue, flat, views, "
      "first_frame, last_frame, best_frame, support, ifnull(on_object, -1), ifnull(area, -1) "
      "FROM objects ORDER BY id");
  const auto frameIn = [&](int column, const char* what) {
    return world.places.indexOf(static_cast<std::size_t>(within(rows, column, frames, what)));
  };
  while (rows.next()) {
    WorldObject object;
    object.id = static_cast<int>(world.objects.size());
    if (rows.integer(0) != object.id) database.failDamaged("its objects have gaps");
    object.givenName = printable(rows.text(1));
    const auto number = [&](int column) { return rows.finite(column, "a number of an object"); };
    object.center = {number(2), number(3), number(4)};
    object.size = {number(5), number(6), number(7)};
    object.yaw = number(8);
    for (int i = 0; i < 3; ++i)
      object.color[static_cast<std::size_t>(i)] = static_cast<int>(within(rows, 9 + i, 256, "color"));
    object.flat = rows.integer(12) != 0;
    object.views = static_cast<std::size_t>(within(rows, 13, frames + 1, "number of views"));
    object.firstFrame = frameIn(14, "first frame");
    object.lastFrame = frameIn(15, "last frame");
    object.bestFrame = frameIn(16, "best frame");
    const auto support = std::find(supportNames.begin(), supportNames.end(), rows.text(17));
    if (support == supportNames.end()) database.failDamaged("an object stands on nothing that is known");
    object.support = static_cast<Support>(support - supportNames.begin());
    object.onObject = static_cast<int>(rows.integer(18));
    object.area = static_cast<int>(rows.integer(19));
    world.objects.push_back(std::move(object));
  }
  for (const WorldObject& object : world.objects)
    if ((object.onObject != -1 && world.findObject(object.onObject) == nullptr) ||
        (object.area != -1 && world.findArea(object.area) == nullptr))
      database.failDamaged("object {} is on or in what is missing", object.id);
  readObjectNames(world);
}

void WorldStore::readObjectNames(WorldMap& world) const {
  const Database& database = store_.database();
  const auto objectIn = [&](const Statement& row) -> WorldObject& {
    if (row.integer(0) < 0 || row.integer(0) >= static_cast<std::int64_t>(world.objects.size()))
      database.failDamaged("a word is of an object that is missing");
    return world.objects[static_cast<std::size_t>(row.integer(0))];
  };
  const Vocabulary& vocabulary = world.places.vocabulary;
  Statement words(
      database,
      "SELECT object, label, probability FROM object_words ORDER BY object, probability DESC, label");
  while (words.next()) {
    const std::int64_t label = words.integer(1);
    if (label < 0 || label >= static_cast<std::int64_t>(vocabulary.size()))
      database.failDamaged("an object's word is {}", label);
    objectIn(words).words.push_back({vocabulary[static_cast<std::size_t>(label)],
                                     static_cast<float>(words.finite(2, "the probability of a word"))});
  }
  if (!sqlite::hasTable(database, "object_classes")) return;  // file of an older program
  Statement classes(
      database,
      "SELECT object, class, probability FROM object_classes ORDER BY object, probability DESC, class");
  while (classes.next()) {
    const double probability = classes.real(2);
    if (!(probability >= 0 && probability <= 1))
      database.failDamaged("the class of an object has no probability");
    objectIn(classes).shapeClasses.push_back({printable(classes.text(1)), static_cast<float>(probability)});
  }
}

}  // namespace estancia
