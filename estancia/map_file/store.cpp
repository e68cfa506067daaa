// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/store.hpp"

#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/map_file/sqlite.hpp"
#include "estancia/map_file/store_files.hpp"
#include "estancia/map_file/store_read.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using namespace storage;
using sqlite::Database;
using sqlite::Statement;

constexpr int maxBeside = 16'000'000;  // the -wal file after a checkpoint [bytes]

// Decisions, merges and first frames are history: they may name nodes that have been absorbed since.
constexpr const char* schema = R"sql(
CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE labels(id INTEGER PRIMARY KEY, label TEXT NOT NULL);
CREATE TABLE frames(id INTEGER PRIMARY KEY, name TEXT NOT NULL, timestamp REAL, x REAL, y REAL, z REAL,
                    qx REAL, qy REAL, qz REAL, qw REAL, room TEXT NOT NULL, node INTEGER NOT NULL);
CREATE INDEX frames_of_node ON frames(node);
CREATE TABLE descriptors(frame INTEGER PRIMARY KEY, probabilities BLOB NOT NULL);
CREATE TABLE images(frame INTEGER PRIMARY KEY, jpeg BLOB NOT NULL);
CREATE TABLE nodes(id INTEGER PRIMARY KEY, frames INTEGER NOT NULL, mean BLOB NOT NULL, sigma BLOB NOT NULL,
                   state BLOB NOT NULL);
CREATE TABLE transitions(source INTEGER NOT NULL, target INTEGER NOT NULL, count INTEGER NOT NULL,
                         first_frame INTEGER NOT NULL, PRIMARY KEY(source, target)) WITHOUT ROWID;
CREATE TABLE decisions(frame INTEGER PRIMARY KEY, kind INTEGER NOT NULL, node INTEGER NOT NULL,
                       current INTEGER NOT NULL, to_current REAL, other INTEGER NOT NULL, to_other REAL,
                       tau_join REAL, tau_revisit REAL);
CREATE TABLE merges(id INTEGER PRIMARY KEY, frame INTEGER NOT NULL, kept INTEGER NOT NULL,
                    absorbed INTEGER NOT NULL, distance REAL, threshold REAL);
CREATE TABLE state(key TEXT PRIMARY KEY, bytes BLOB NOT NULL);
)sql";

constexpr const char* schemaOfDrives = R"sql(
CREATE TABLE IF NOT EXISTS drives(first_frame INTEGER PRIMARY KEY, name TEXT NOT NULL,
                                  fingerprint TEXT NOT NULL, aligned INTEGER NOT NULL, x REAL, y REAL, z REAL, qx REAL, qy REAL, qz REAL,
                                  qw REAL);
CREATE TABLE IF NOT EXISTS given_poses(frame INTEGER PRIMARY KEY, x REAL, y REAL, z REAL, qx REAL, qy REAL,
                                       qz REAL, qw REAL);
)sql";

constexpr const char* schemaOfRooms = R"sql(
DROP TABLE IF EXISTS predicted_rooms;
DROP TABLE IF EXISTS predictions;
DROP TABLE IF EXISTS room_evidence;
DELETE FROM meta WHERE key = 'rooms_by_name';
CREATE TABLE predicted_rooms(id INTEGER PRIMARY KEY, name TEXT NOT NULL);
CREATE TABLE predictions(frame INTEGER PRIMARY KEY, probabilities BLOB NOT NULL);
CREATE TABLE room_evidence(frame INTEGER NOT NULL, label INTEGER NOT NULL, log_odds BLOB NOT NULL,
                           PRIMARY KEY(frame, label)) WITHOUT ROWID;
)sql";

/// The parts of a vocabulary as JSON, [[labels, weight], …].
std::string partsToJson(const Vocabulary& vocabulary) {
  auto parts = nlohmann::json::array();
  for (const LabelPart& part : vocabulary.layout().parts) parts.push_back({part.size, part.weight});
  return parts.dump();
}

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

}  // namespace

/// Invariant: a writer has an open transaction with what is not committed, unless an error has ended it. A
/// new map is a database in memory until its first commit() writes the file, which may replace an older map;
/// `statements` belong to the connection and are dropped before it is replaced or closed.
struct MapStore::Impl {
  Impl(const fs::path& file, Access wanted, Database&& opened, Identity named)
      : path(file), access(wanted), database(std::move(opened)), identity(std::move(named)) {}

  fs::path path;
  Access access;
  Database database;
  Identity identity;
  /// The first commit may take the place of an older map.
  bool replacing = false;
  /// The file that is written; writers only.
  struct stat written {};
  /// False before the first commit of a new map: all of it is in memory.
  bool onDisk = true;
  /// Writers only: those that were mapped, and of them those that are not kept.
  std::size_t frames = 0, leftOut = 0, leftOutOnDisk = 0;
  /// For writing, by their text, which is a literal.
  std::map<std::string_view, Statement> statements;

  ~Impl() {
    statements.clear();
    if (!onDisk) return;
    database.waitForLocks(0);
    if (database.inTransaction()) database.tryRun("ROLLBACK");
    // The last one out leaves a single plain file, which read-only media can hold, too. While others still
    // use the map this fails, and one of them will do it.
    database.tryRun("PRAGMA query_only = OFF; PRAGMA journal_mode = DELETE");
  }

  void requireWriting() const {
    if (access != Access::write) refuse(path, ErrorCode::invalidState, "the map was opened for reading");
    if (!database.inTransaction())
      refuse(path, ErrorCode::invalidState,
             "an earlier error has ended the writing of this map; open it again");
  }

  /// The only row that a query has of a frame.
  Statement rowOf(std::size_t frame, std::string_view sql) const {
    Statement row(database, sql, frame);
    if (!row.next()) failNoFrame(frame, frameCountOf(database));
    return row;
  }

  [[noreturn]] void failNoFrame(std::size_t frame, std::size_t count) const {
    refuse(path, ErrorCode::unknownName,
           "there is no frame {}; the map has {} frames, and keeps fewer where its size is bounded", frame,
           count);
  }

  void requireFrame(std::size_t frame) const {
    if (frame >= frames) failNoFrame(frame, frames);
  }

  template <typename... Values>
  void write(std::string_view sql, const Values&... values) {
    requireWriting();
    const auto cached = statements.find(sql);
    Statement& statement = cached != statements.end()
                               ? cached->second
                               : statements.emplace(sql, Statement(database, sql)).first->second;
    statement.bindAll(values...);
    allOrNothing([&] { statement.execute(); });
  }

  /// Half of a frame must never be committed: a failed step ends the writing and drops what is not committed.
  template <typename Step>
  void allOrNothing(const Step& step) {
    try {
      step();
    } catch (...) {
      if (database.inTransaction()) database.tryRun("ROLLBACK");
      throw;
    }
  }

  /// The first commit: from memory to a file beside, then to its name.
  void moveToDisk() {
    const fs::path part = partFile(path);
    std::error_code ignored;
    fs::remove(part, ignored);
    try {
      database.run("VACUUM INTO " + quoted(part.string()));
      if (::access(part.c_str(), R_OK | W_OK) != 0)
        refuse(path, ErrorCode::fileUnwritable,
               "files that are made here may not be read by who makes them; change the umask");
      flushToDisk(part);
      stat(part.c_str(), &written);
      if (replacing && fs::exists(path))
        renameOver(part, path);
      else
        renameToNew(part, path);
      flushToDisk(folderOf(path));
    } catch (...) {
      fs::remove(part, ignored);
      removeCompanions(part);
      throw;
    }
    statements.clear();
    database = Database(path, Database::Mode::write);
    onDisk = true;
    requireInPlace();  // another may have taken its place since
    startWriting();
  }

  void startWriting() {
    database.waitForLocks(lockPatience);
    database.run("PRAGMA journal_mode = WAL");
    // A commit is on the disk when it returns, so that a power cut costs the last second, too, and no more:
    // with NORMAL it would cost all that is not in the file yet. There is one commit a second.
    database.run("PRAGMA synchronous = FULL");
    // Frees the space that one large commit has left beside the file.
    database.run(fmt::format("PRAGMA journal_size_limit = {}", maxBeside));
    database.run("BEGIN IMMEDIATE");
    if (!onDisk) return;
    database.run(schemaOfDrives);
    database.run(fmt::format("PRAGMA user_version = {}", formatVersion));
  }

  /// A file that has been removed can still be written to, all for nothing.
  void requireInPlace() const {
    struct stat now {};
    if (stat(path.c_str(), &now) != 0 || now.st_ino != written.st_ino || now.st_dev != written.st_dev)
      refuse(path, ErrorCode::fileNotFound,
             "the map was removed, moved or replaced while it was being written; map again");
  }
};

MapStore::MapStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapStore::MapStore(MapStore&&) noexcept = default;
MapStore& MapStore::operator=(MapStore&&) noexcept = default;
MapStore::~MapStore() = default;

MapStore MapStore::create(const fs::path& name, const Identity& identity, ExistingMap existing) {
  const fs::path path = outputTarget(name);  // what a link leads to, as SQLite does
  const bool replacing = existing == ExistingMap::replace && fs::exists(path);
  if (replacing) {
    requireReplaceable(path);
  } else {
    if (fs::exists(fs::symlink_status(path))) failExists(path);
    removeCompanions(path);
  }
  requireWritable(folderOf(path));
  auto impl = std::make_unique<Impl>(path, Access::write, Database(path, Database::Mode::memory), identity);
  impl->onDisk = false;
  impl->replacing = replacing;
  impl->database.run(
      fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};", mapApplicationId, formatVersion));
  impl->database.run(schema);
  impl->database.run(schemaOfDrives);
  impl->database.run("BEGIN IMMEDIATE");
  constexpr std::string_view putMeta = "INSERT INTO meta VALUES(?1, ?2)";
  impl->write(putMeta, "vocabulary", identity.vocabulary.digest());
  impl->write(putMeta, "model", identity.model);
  impl->write(putMeta, "settings", identity.settings);
  if (identity.vocabulary.layout().parts.size() > 1)
    impl->write(putMeta, "parts", partsToJson(identity.vocabulary));
  for (std::size_t i = 0; i < identity.vocabulary.size(); ++i)
    impl->write("INSERT INTO labels VALUES(?1, ?2)", i, identity.vocabulary[i]);
  return MapStore(std::move(impl));
}

MapStore MapStore::open(const fs::path& path, Access access) {
  requireMapFile(path);
  const bool writing = access == Access::write;
  struct stat opened {};
  stat(path.c_str(), &opened);
  Database database(path, writing ? Database::Mode::write : Database::Mode::read);
  database.waitForLocks(lockPatience);
  requireOurFormat(database);
  if (writing && database.isReadOnly()) database.fail(SQLITE_READONLY);
  Identity identity = readIdentity(database);
  auto impl = std::make_unique<Impl>(path, access, std::move(database), std::move(identity));
  impl->written = opened;
  if (writing) impl->startWriting();
  MapStore store(std::move(impl));
  store.impl_->frames = store.frameCount();
  store.impl_->leftOut = store.impl_->leftOutOnDisk = leftOutOf(store.impl_->database);
  return store;
}

const MapStore::Identity& MapStore::identity() const {
  return impl_->identity;
}

// ---- writing

void MapStore::addFrame(const MappedFrame& frame, DescriptorView descriptor) {
  impl_->requireWriting();
  requireProbabilities(descriptor, impl_->identity.vocabulary.size(), frame.name);
  if (frame.number >= maxFramesOfMap)
    refuse(impl_->path, ErrorCode::tooLarge, "the map has no number for another frame; begin a new map");
  impl_->write("INSERT INTO descriptors VALUES(?1, ?2)", frame.number, descriptor);
  impl_->write("INSERT INTO frames VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)", frame.number,
               frame.name, frame.timestamp.value_or(std::nan("")), frame.pose, frame.room, frame.node);
  if (frame.number < impl_->frames)
    --impl_->leftOut;
  else
    impl_->leftOut += frame.number - std::exchange(impl_->frames, frame.number + 1);
}

void MapStore::putPose(std::size_t frame, const std::optional<Pose>& pose) {
  impl_->requireFrame(frame);
  impl_->write("UPDATE frames SET x = ?2, y = ?3, z = ?4, qx = ?5, qy = ?6, qz = ?7, qw = ?8 WHERE id = ?1",
               frame, pose);
}

void MapStore::putGivenPose(std::size_t frame, const Pose& pose) {
  impl_->write("INSERT OR REPLACE INTO given_poses VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)", frame, pose);
}

void MapStore::putDrive(const Drive& drive) {
  impl_->write("INSERT OR REPLACE INTO drives VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
               drive.firstFrame, drive.name, drive.fingerprint, drive.isAligned ? 1 : 0, drive.alignment);
}

void MapStore::putImage(std::size_t frame, const std::vector<unsigned char>& jpeg) {
  impl_->requireFrame(frame);
  impl_->write("INSERT OR REPLACE INTO images VALUES(?1, ?2)", frame, std::as_bytes(std::span(jpeg)));
}

void MapStore::putNode(const Node& node, const std::string& state) {
  const std::size_t labels = impl_->identity.vocabulary.size();
  if (node.mean.size() != labels || node.sigma.size() != labels)
    fail(ErrorCode::mismatch, "node {} has {} means and {} deviations for {} labels", node.id,
         node.mean.size(), node.sigma.size(), labels);
  impl_->write("INSERT OR REPLACE INTO nodes VALUES(?1, ?2, ?3, ?4, ?5)", node.id, node.frames,
               std::span(node.mean), std::span(node.sigma), std::as_bytes(std::span(state)));
}

void MapStore::putTransition(const Transition& transition) {
  impl_->write("INSERT OR REPLACE INTO transitions VALUES(?1, ?2, ?3, ?4)", transition.from, transition.to,
               transition.count, transition.firstFrame);
}

void MapStore::removeTransition(int from, int to) {
  impl_->write("DELETE FROM transitions WHERE source = ?1 AND target = ?2", from, to);
}

void MapStore::putDecision(const Decision& decision) {
  impl_->requireFrame(decision.frame);
  impl_->write("INSERT OR REPLACE INTO decisions VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)", decision.frame,
               static_cast<int>(decision.kind), decision.node, decision.current, decision.toCurrent,
               decision.other, decision.toOther, decision.tauJoin, decision.tauRevisit);
  impl_->write("UPDATE frames SET node = ?2 WHERE id = ?1 AND node <> ?2", decision.frame, decision.node);
}

void MapStore::addMerge(const Merge& merge) {
  impl_->write("INSERT INTO merges(frame, kept, absorbed, distance, threshold) VALUES(?1, ?2, ?3, ?4, ?5)",
               merge.frame, merge.kept, merge.absorbed, merge.distance, merge.threshold);
  impl_->write("UPDATE frames SET node = ?1 WHERE node = ?2", merge.kept, merge.absorbed);
  impl_->write("DELETE FROM nodes WHERE id = ?1", merge.absorbed);
}

void MapStore::clearMap(int firstNode, std::size_t firstFrame) {
  impl_->write("DELETE FROM nodes WHERE id >= ?1", firstNode);
  impl_->write("DELETE FROM merges WHERE absorbed >= ?1", firstNode);
  impl_->write("DELETE FROM transitions WHERE source >= ?1 OR target >= ?1", firstNode);
  impl_->write("DELETE FROM decisions WHERE frame >= ?1", firstFrame);
  impl_->write("UPDATE frames SET node = -1 WHERE id >= ?1", firstFrame);
}

void MapStore::putPredictions(const RoomPredictions& predictions) {
  impl_->requireWriting();
  const std::vector<std::size_t> numbers = frameNumbers();
  const std::size_t rows = predictions.probabilities.size(), rooms = predictions.rooms.size();
  if (rows > numbers.size() || rooms == 0 || predictions.probabilities.labels() != rooms)
    refuse(impl_->path, ErrorCode::mismatch,
           "predictions for {} frames and {} rooms do not fit {} frames and {} rooms", rows,
           predictions.probabilities.labels(), numbers.size(), rooms);
  if (std::ranges::any_of(predictions.rooms, &std::string::empty))
    refuse(impl_->path, ErrorCode::invalidInput, "a predicted room has no name");
  impl_->statements.clear();  // statements for the older tables
  impl_->allOrNothing([&] { impl_->database.run(schemaOfRooms); });
  impl_->write("INSERT OR REPLACE INTO meta VALUES('classifier', ?1)", predictions.classifier);
  if (predictions.areByName)
    impl_->write("INSERT INTO meta VALUES('rooms_by_name', ?1)",
                 nlohmann::json{{"prior", predictions.prior}, {"listed", predictions.areListed}}.dump());
  for (std::size_t i = 0; i < rooms; ++i)
    impl_->write("INSERT INTO predicted_rooms VALUES(?1, ?2)", i, predictions.rooms[i]);
  for (std::size_t i = 0; i < rows; ++i) {
    const DescriptorView row = predictions.probabilities.row(i);
    requireProbabilities(row, rooms, fmt::format("the rooms of frame {}", numbers[i]));
    if (isPredicted(predictions, i)) impl_->write("INSERT INTO predictions VALUES(?1, ?2)", numbers[i], row);
  }
  for (const RoomEvidence& told : predictions.evidence) {
    if (told.image >= rows || told.label >= impl_->identity.vocabulary.size() || told.logOdds.size() != rooms)
      refuse(impl_->path, ErrorCode::mismatch, "evidence of rooms is of no frame, label or room of the map");
    impl_->write("INSERT INTO room_evidence VALUES(?1, ?2, ?3)", numbers[told.image], told.label,
                 DescriptorView(told.logOdds));
  }
}

void MapStore::leaveOut(const std::vector<std::size_t>& frames) {
  if (frames.empty()) return;
  impl_->requireWriting();
  std::vector<std::string> tables;
  {
    Statement names(impl_->database,
                    "SELECT printf('\"%w\"', m.name) FROM sqlite_master m, pragma_table_info(m.name) c "
                    "WHERE m.type = 'table' AND c.name = 'frame' AND c.pk = 1");
    while (names.next()) tables.push_back(names.text(0));
  }
  impl_->allOrNothing([&] {
    for (const std::string& table : tables) {
      Statement remove(impl_->database, fmt::format("DELETE FROM {} WHERE frame = ?1", table));
      for (const std::size_t frame : frames) remove.executeWith(frame);
    }
    Statement remove(impl_->database, "DELETE FROM frames WHERE id = ?1");
    for (const std::size_t frame : frames) {
      remove.executeWith(frame);
      impl_->leftOut += static_cast<std::size_t>(sqlite3_changes(impl_->database.handle()));
    }
  });
}

void MapStore::putState(const std::string& key, const std::string& bytes) {
  impl_->write("INSERT OR REPLACE INTO state VALUES(?1, ?2)", key, std::as_bytes(std::span(bytes)));
}

void MapStore::commit() {
  impl_->requireWriting();
  if (impl_->leftOut != impl_->leftOutOnDisk)
    impl_->write("INSERT OR REPLACE INTO meta VALUES(?1, ?2)", leftOutKey, std::to_string(impl_->leftOut));
  impl_->leftOutOnDisk = impl_->leftOut;
  impl_->allOrNothing([this] {
    if (impl_->onDisk) impl_->requireInPlace();
    impl_->database.run("COMMIT");
  });
  if (impl_->onDisk)
    impl_->database.run("BEGIN IMMEDIATE");  // at once: there is but one writer
  else
    impl_->moveToDisk();
}

void MapStore::compact() {
  commit();
  impl_->statements.clear();
  impl_->database.run("COMMIT");
  impl_->database.run("VACUUM");
  impl_->database.run("BEGIN IMMEDIATE");
}

const fs::path& MapStore::path() const {
  return impl_->path;
}

sqlite::Database& MapStore::database() {
  return impl_->database;
}

// ---- reading

void MapStore::beginReading() {
  impl_->database.run("BEGIN");
}

void MapStore::endReading() {
  impl_->database.run("COMMIT");
}

std::uint64_t MapStore::bytes() const {
  const std::int64_t pages =
      impl_->database.number("PRAGMA page_count") - impl_->database.number("PRAGMA freelist_count");
  return static_cast<std::uint64_t>(pages * impl_->database.number("PRAGMA page_size"));
}

std::size_t MapStore::frameCount() const {
  return frameCountOf(impl_->database);
}

std::vector<std::size_t> MapStore::frameNumbers() const {
  return impl_->database.numbers("SELECT id FROM frames ORDER BY id");
}

std::vector<std::size_t> MapStore::namedFrames() const {
  constexpr std::int64_t ofPlace = 3;
  const Database& database = impl_->database;
  std::vector<std::size_t> frames;
  const auto add = [&frames](std::int64_t number) {
    if (number >= 0) frames.push_back(static_cast<std::size_t>(number));
  };
  for (const Drive& drive : readDrives(impl_->database)) frames.push_back(drive.firstFrame);
  Statement nodes(database,
                  "SELECT id, (SELECT max(frames.id) FROM frames WHERE node = nodes.id) FROM nodes");
  Statement next(database, "SELECT id FROM frames WHERE node = ?1 AND id >= ?2 ORDER BY id LIMIT 1");
  const auto nextOf = [&next](std::int64_t node, std::int64_t from) {
    next.bindAll(node, from);
    return next.next() ? next.integer(0) : -1;
  };
  while (nodes.next()) {
    const std::int64_t node = nodes.integer(0), first = nextOf(node, 0), last = nodes.integer(1);
    for (std::int64_t i = 0; i + 1 < ofPlace && first >= 0; ++i)
      add(nextOf(node, first + (last - first) / (ofPlace - 1) * i));
    add(last);
  }
  return frames;
}

std::vector<Visit> MapStore::visits() const {
  return readVisits(impl_->database);
}

TopologicalMap MapStore::load(std::size_t maxFrames, const std::vector<std::size_t>& also) const {
  Database& database = impl_->database;
  if (database.inTransaction()) return readContent(database, impl_->identity, maxFrames, also);
  database.run("BEGIN");  // one moment of the map for all its tables, whatever is written meanwhile
  try {
    TopologicalMap map = readContent(database, impl_->identity, maxFrames, also);
    database.run("COMMIT");
    return map;
  } catch (...) {
    database.tryRun("ROLLBACK");
    throw;
  }
}

std::vector<Transition> MapStore::transitions() const {
  return estancia::readTransitions(impl_->database);
}

std::optional<std::string> MapStore::findState(const std::string& key) const {
  Statement row(impl_->database, "SELECT bytes FROM state WHERE key = ?1", key);
  if (!row.next()) return std::nullopt;
  return row.blob(0);
}

std::vector<std::pair<int, std::string>> MapStore::nodeStates() const {
  Statement rows(impl_->database, "SELECT id, state FROM nodes ORDER BY id");
  std::vector<std::pair<int, std::string>> states;
  while (rows.next()) {
    const int id = rows.node(0, 0, "a node's number");
    states.emplace_back(id, rows.blob(1));
  }
  return states;
}

LexicalDescriptor MapStore::descriptor(std::size_t frame) const {
  const Statement row = impl_->rowOf(frame, "SELECT probabilities FROM descriptors WHERE frame = ?1");
  LexicalDescriptor descriptor;
  readValues(impl_->database, row.bytes(0), impl_->identity.vocabulary.size(),
             fmt::format("the descriptor of frame {}", frame), descriptor);
  return descriptor;
}

std::optional<Pose> MapStore::pose(std::size_t frame) const {
  return impl_->rowOf(frame, "SELECT x, y, z, qx, qy, qz, qw FROM frames WHERE id = ?1").pose(0);
}

std::optional<Pose> MapStore::givenPose(std::size_t frame) const {
  if (!sqlite::hasTable(impl_->database, "given_poses")) return std::nullopt;
  Statement row(impl_->database, "SELECT x, y, z, qx, qy, qz, qw FROM given_poses WHERE frame = ?1", frame);
  if (!row.next()) return std::nullopt;
  const std::optional<Pose> pose = row.pose(0);
  if (!pose) impl_->database.failDamaged("the given pose of frame {} is none", frame);
  return pose;
}

bool MapStore::hasPoses() const {
  return impl_->database.number("SELECT EXISTS(SELECT 1 FROM frames WHERE x IS NOT NULL)") != 0;
}

std::vector<Drive> MapStore::drives() const {
  return readDrives(impl_->database);
}

Frame MapStore::frame(std::size_t frame) const {
  const Statement row =
      impl_->rowOf(frame, "SELECT name, timestamp, x, y, z, qx, qy, qz, qw FROM frames WHERE id = ?1");
  const double timestamp = row.real(1);
  return {row.text(0), std::isfinite(timestamp) ? std::optional(timestamp) : std::nullopt, row.pose(2), ""};
}

void MapStore::forEachDescriptor(std::size_t first,
                                 const std::function<bool(std::size_t, DescriptorView)>& visit) const {
  Statement rows(impl_->database,
                 "SELECT id, probabilities FROM frames LEFT JOIN descriptors ON frame = id WHERE id >= ?1 "
                 "ORDER BY id",
                 first);
  LexicalDescriptor descriptor;
  while (rows.next()) {
    const auto frame = static_cast<std::size_t>(rows.integer(0));
    readValues(impl_->database, rows.bytes(1), impl_->identity.vocabulary.size(),
               fmt::format("the descriptor of frame {}", frame), descriptor);
    if (!visit(frame, descriptor)) return;
  }
}

std::vector<std::size_t> MapStore::imageFrames() const {
  return impl_->database.numbers("SELECT frame FROM images WHERE frame >= 0 ORDER BY frame");
}

std::vector<unsigned char> MapStore::image(std::size_t frame) const {
  Statement row(impl_->database, "SELECT jpeg FROM images WHERE frame = ?1", frame);
  if (!row.next()) return {};
  const auto bytes = row.bytes(0);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  return {data, data + bytes.size()};
}

}  // namespace estancia
