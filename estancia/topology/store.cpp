// SPDX-License-Identifier: Apache-2.0
#include "estancia/topology/store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/topology/drive_store.hpp"
#include "estancia/topology/sqlite.hpp"
#include "estancia/topology/store_read.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using sqlite::Database;
using sqlite::Statement;

constexpr std::int64_t formatVersion = 6;
/// Has the same tables for places, but for drives; writing it makes it the newest.
constexpr std::int64_t oldestVersion = 4;
constexpr int lockPatience = 1000;  // a reader may hold a lock for a moment while it recovers [ms]

constexpr double noNumber = std::numeric_limits<double>::quiet_NaN();  // stored as NULL
constexpr Pose unknownPose{noNumber, noNumber, noNumber, noNumber, noNumber, noNumber, noNumber};

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

fs::path folderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

[[noreturn]] void refuse(const fs::path& path, ErrorCode code, const std::string& why) {
  throw Error(code, fmt::format("{}: {}", path.string(), why));
}

[[noreturn]] void failExists(const fs::path& path) {
  refuse(path, ErrorCode::fileExists,
         "exists already; give another name, or continue it by `estancia map --continue`");
}

/// Throws unless a file of some size can be made in the folder: tried out, because permission bits say
/// nothing about full or read-only disks (nor to root).
void requireWritable(const fs::path& folder) {
  if (!fs::is_directory(folder))
    refuse(folder, ErrorCode::fileNotFound, "there is no such folder; make it first");
  std::string probe = (folder / ".estancia-XXXXXX").string();
  const int file = mkstemp(probe.data());
  int problem = file < 0 ? errno : 0;
  if (file >= 0) {
    unlink(probe.c_str());
    const std::array<char, 65536> room{};
    errno = ENOSPC;  // what a short write means
    if (write(file, room.data(), room.size()) != static_cast<ssize_t>(room.size())) problem = errno;
    close(file);
  }
  if (problem == ENOSPC || problem == EDQUOT || problem == EFBIG)
    refuse(folder, ErrorCode::fileUnwritable, "the disk is full; free some space first");
  if (problem != 0)
    refuse(folder, ErrorCode::fileUnwritable,
           fmt::format("cannot write in this folder ({}); choose another one", std::strerror(problem)));
}

void flushToDisk(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  fsync(file);
  close(file);
}

/// Renames without ever replacing.
void renameToNew(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
  if (errno == EEXIST) failExists(to);
  if (errno != EINVAL && errno != ENOSYS)
    refuse(to, ErrorCode::fileUnwritable, fmt::format("cannot be made ({})", std::strerror(errno)));
  if (fs::exists(fs::symlink_status(to))) failExists(to);  // a file system without that kind of rename
  fs::rename(from, to);
}

/// What SQLite keeps beside a file. Left behind there, it would be played into the next file of that name.
void removeCompanions(const fs::path& path) {
  for (const char* ending : {"-wal", "-shm", "-journal"}) {
    std::error_code ignored;
    fs::remove(path.string() + ending, ignored);
  }
}

/// Throws unless the file is empty or begins as a map file, intact or not: nothing else is ever replaced.
void requireReplaceable(const fs::path& path) {
  if (fs::is_regular_file(path) && fs::file_size(path) == 0) return;
  if (!isMapFile(path))
    refuse(path, ErrorCode::unsupportedFile,
           "not a map file, so it is not replaced; give another name or remove it first");
}

/// Puts the finished file `from` in the place of the map `to`. A map that a process is writing is refused.
void renameOver(const fs::path& from, const fs::path& to) {
  requireReplaceable(to);
  Database old(to, Database::Mode::write);
  old.waitForLocks(lockPatience);
  // Takes the old map's -wal in and away, then keeps writers out until its file has gone.
  if (!old.tryRun("PRAGMA journal_mode = DELETE") || !old.tryRun("BEGIN EXCLUSIVE")) {
    if (const int code = sqlite3_errcode(old.handle()); code == SQLITE_BUSY) old.fail(code);
    removeCompanions(to);  // the old map is damaged: nobody can be at work on it
  }
  fs::rename(from, to);
}

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

void requireMapFile(const fs::path& path) {
  std::error_code problem;
  const fs::file_status status = fs::status(path, problem);
  if (!fs::exists(status))
    refuse(path, ErrorCode::fileNotFound, "there is no such map; make one by `estancia map`");
  if (!fs::is_regular_file(status))
    refuse(path, ErrorCode::unsupportedFile, "not a regular file; give the *.estancia file of a map");
  constexpr std::uintmax_t smallest = 512;  // SQLite's smallest page
  if (const auto size = fs::file_size(path, problem); !problem && size < smallest)
    refuse(path, ErrorCode::truncatedFile,
           fmt::format("only {} bytes long, too short for a map; restore a copy or map the sequence again",
                       size));
}

void requireOurFormat(Database& database) {
  const fs::path& path = database.path();
  if (database.number("PRAGMA application_id") != mapApplicationId)
    refuse(path, ErrorCode::unsupportedFile,
           "another program's SQLite file, not a map; give a file that `estancia map` has written");
  const std::int64_t version = database.number("PRAGMA user_version");
  if (version < 1) database.failDamaged(fmt::format("its format version is {}", version));
  if (version < oldestVersion || version > formatVersion)
    refuse(
        path, ErrorCode::unsupportedFile,
        fmt::format("map format {}, but this Estancia reads map formats {} to {}; {}", version, oldestVersion,
                    formatVersion, version < oldestVersion ? "map the sequence again" : "update Estancia"));
  // SQLite notices missing pages, but fills up a last page that was cut. (Beside a -wal file the size may
  // change.)
  std::error_code problem;
  const auto size = fs::file_size(database.path(), problem);
  const auto pageSize = static_cast<std::uintmax_t>(database.number("PRAGMA page_size"));
  if (!problem && size % pageSize != 0 && !fs::exists(path.string() + "-wal"))
    database.failDamaged("its last page is incomplete");
}

}  // namespace

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
  /// Writers only.
  std::size_t frames = 0;
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

  [[noreturn]] void failNoFrame(std::size_t frame, std::size_t count) const {
    refuse(path, ErrorCode::unknownName,
           fmt::format("there is no frame {}; the map has {} frames", frame, count));
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
    const fs::path part = folderOf(path) / fmt::format(".{}.{}.part", path.filename().string(), getpid());
    std::error_code ignored;
    fs::remove(part, ignored);
    try {
      database.run("VACUUM INTO " + quoted(part.string()));
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
    // In WAL mode NORMAL loses nothing when the process dies; a power cut may cost the last commits.
    database.run("PRAGMA synchronous = NORMAL");
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
  const bool replacing = existing == ExistingMap::replace && fs::exists(name);
  const fs::path path = replacing ? fs::canonical(name) : name;  // what a link leads to, as SQLite does
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
  return store;
}

const MapStore::Identity& MapStore::identity() const {
  return impl_->identity;
}

// ---- writing

void MapStore::addFrame(std::size_t index, const MappedFrame& frame, DescriptorView descriptor) {
  impl_->requireWriting();
  if (index != impl_->frames)
    refuse(impl_->path, ErrorCode::invalidInput,
           fmt::format("frame {} cannot be added; the next one is {}", index, impl_->frames));
  requireProbabilities(descriptor, impl_->identity.vocabulary.size(), frame.name);
  const Pose pose = frame.pose.value_or(unknownPose);
  impl_->write("INSERT INTO descriptors VALUES(?1, ?2)", index, descriptor);
  impl_->write("INSERT INTO frames VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)", index,
               frame.name, frame.timestamp.value_or(noNumber), pose.x, pose.y, pose.z, pose.qx, pose.qy,
               pose.qz, pose.qw, frame.room, frame.node);
  ++impl_->frames;
}

void MapStore::putPose(std::size_t frame, const std::optional<Pose>& pose) {
  impl_->requireFrame(frame);
  const Pose p = pose.value_or(unknownPose);
  impl_->write("UPDATE frames SET x = ?2, y = ?3, z = ?4, qx = ?5, qy = ?6, qz = ?7, qw = ?8 WHERE id = ?1",
               frame, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
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

void MapStore::clearMap() {
  impl_->write("DELETE FROM nodes");
  impl_->write("DELETE FROM decisions");
  impl_->write("DELETE FROM merges");
  impl_->write("UPDATE frames SET node = -1");
  clearTransitions();
}

void MapStore::clearTransitions() {
  impl_->write("DELETE FROM transitions");
}

void MapStore::putPredictions(const RoomPredictions& predictions) {
  impl_->requireWriting();
  const std::size_t rows = predictions.probabilities.size(), rooms = predictions.rooms.size();
  if (rows > impl_->frames || rooms == 0 || predictions.probabilities.labels() != rooms)
    refuse(impl_->path, ErrorCode::mismatch,
           fmt::format("predictions for {} frames and {} rooms do not fit {} frames and {} rooms", rows,
                       predictions.probabilities.labels(), impl_->frames, rooms));
  if (std::ranges::any_of(predictions.rooms, &std::string::empty))
    refuse(impl_->path, ErrorCode::invalidInput, "a predicted room has no name");
  impl_->statements.clear();  // those of the older tables
  impl_->allOrNothing([&] { impl_->database.run(schemaOfRooms); });
  impl_->write("INSERT OR REPLACE INTO meta VALUES('classifier', ?1)", predictions.classifier);
  if (predictions.areByName)
    impl_->write("INSERT INTO meta VALUES('rooms_by_name', ?1)",
                 nlohmann::json{{"prior", predictions.prior}, {"listed", predictions.areListed}}.dump());
  for (std::size_t i = 0; i < rooms; ++i)
    impl_->write("INSERT INTO predicted_rooms VALUES(?1, ?2)", i, predictions.rooms[i]);
  for (std::size_t i = 0; i < rows; ++i) {
    const DescriptorView row = predictions.probabilities.row(i);
    requireProbabilities(row, rooms, fmt::format("the rooms of frame {}", i));
    impl_->write("INSERT INTO predictions VALUES(?1, ?2)", i, row);
  }
  for (const RoomEvidence& told : predictions.evidence) {
    if (told.image >= rows || told.label >= impl_->identity.vocabulary.size() || told.logOdds.size() != rooms)
      refuse(impl_->path, ErrorCode::mismatch, "evidence of rooms is of no frame, label or room of the map");
    impl_->write("INSERT INTO room_evidence VALUES(?1, ?2, ?3)", told.image, told.label,
                 DescriptorView(told.logOdds));
  }
}

void MapStore::putState(const std::string& key, const std::string& bytes) {
  impl_->write("INSERT OR REPLACE INTO state VALUES(?1, ?2)", key, std::as_bytes(std::span(bytes)));
}

void MapStore::commit() {
  impl_->requireWriting();
  impl_->allOrNothing([this] {
    if (impl_->onDisk) impl_->requireInPlace();
    impl_->database.run("COMMIT");
  });
  if (impl_->onDisk)
    impl_->database.run("BEGIN IMMEDIATE");  // at once: there is but one writer
  else
    impl_->moveToDisk();
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

std::size_t MapStore::frameCount() const {
  const std::int64_t count = impl_->database.number("SELECT ifnull(max(id) + 1, 0) FROM frames");
  if (count < 0) impl_->database.failDamaged("its frames have negative numbers");
  return static_cast<std::size_t>(count);
}

TopologicalMap MapStore::load(std::size_t mostFrames) const {
  Database& database = impl_->database;
  if (database.inTransaction()) return readContent(database, impl_->identity, mostFrames);
  database.run("BEGIN");  // one moment of the map for all its tables, whatever is written meanwhile
  try {
    TopologicalMap map = readContent(database, impl_->identity, mostFrames);
    database.run("COMMIT");
    return map;
  } catch (...) {
    database.tryRun("ROLLBACK");
    throw;
  }
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
    if (rows.integer(0) < 0 || rows.integer(0) > std::numeric_limits<int>::max())
      impl_->database.failDamaged(fmt::format("a node's number is {}", rows.integer(0)));
    states.emplace_back(static_cast<int>(rows.integer(0)), rows.blob(1));
  }
  return states;
}

LexicalDescriptor MapStore::descriptor(std::size_t frame) const {
  Statement row(impl_->database, "SELECT probabilities FROM descriptors WHERE frame = ?1", frame);
  if (!row.next()) impl_->failNoFrame(frame, frameCount());
  LexicalDescriptor descriptor;
  readValues(impl_->database, row.bytes(0), impl_->identity.vocabulary.size(),
             fmt::format("the descriptor of frame {}", frame), descriptor);
  return descriptor;
}

std::optional<Pose> MapStore::pose(std::size_t frame) const {
  Statement row(impl_->database, "SELECT x, y, z, qx, qy, qz, qw FROM frames WHERE id = ?1", frame);
  if (!row.next()) impl_->failNoFrame(frame, frameCount());
  return readPose(row, 0);
}

Frame MapStore::frame(std::size_t frame) const {
  Statement row(impl_->database, "SELECT name, timestamp, x, y, z, qx, qy, qz, qw FROM frames WHERE id = ?1",
                frame);
  if (!row.next()) impl_->failNoFrame(frame, frameCount());
  const double timestamp = row.real(1);
  return {row.text(0), std::isfinite(timestamp) ? std::optional(timestamp) : std::nullopt, readPose(row, 2),
          ""};
}

void MapStore::forEachDescriptor(std::size_t first,
                                 const std::function<bool(std::size_t, DescriptorView)>& visit) const {
  Statement rows(impl_->database,
                 "SELECT frame, probabilities FROM descriptors WHERE frame >= ?1 ORDER BY frame", first);
  LexicalDescriptor descriptor;
  for (std::size_t frame = first; rows.next(); ++frame) {
    if (rows.integer(0) != static_cast<std::int64_t>(frame))
      impl_->database.failDamaged(fmt::format("the descriptor of frame {} is missing", frame));
    readValues(impl_->database, rows.bytes(1), impl_->identity.vocabulary.size(), "a descriptor", descriptor);
    if (!visit(frame, descriptor)) return;
  }
}

std::vector<std::size_t> MapStore::imageFrames() const {
  Statement rows(impl_->database, "SELECT frame FROM images WHERE frame >= 0 ORDER BY frame");
  std::vector<std::size_t> frames;
  while (rows.next()) frames.push_back(static_cast<std::size_t>(rows.integer(0)));
  return frames;
}

std::vector<unsigned char> MapStore::image(std::size_t frame) const {
  Statement row(impl_->database, "SELECT jpeg FROM images WHERE frame = ?1", frame);
  if (!row.next()) return {};
  const auto bytes = row.bytes(0);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  return {data, data + bytes.size()};
}

}  // namespace estancia
