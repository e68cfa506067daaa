// rosbag2's SQLite storage: a table of topics and one of messages.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <limits>
#include <mutex>
#include <unordered_map>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/ros/bag_part.hpp"
#include "estancia/ros/sqlite_bytes.hpp"

namespace estancia::ros {
namespace {

// Number of unreadable messages in a row after which the rest is given up.
constexpr sqlite3_int64 longestGap = sqlite3_int64{1} << 24U;

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
struct CloseBlob {
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};
using Statement = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;
using Blob = std::unique_ptr<sqlite3_blob, CloseBlob>;

std::string_view textAt(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr ? std::string_view() : std::string_view(text, sqlite3_column_bytes(row, column));
}

class SqlitePart : public BagPart {
 public:
  explicit SqlitePart(FileBytes file) : BagPart(file.name()), bytes_(std::move(file)) {
    open();
    readTopics();
    readMessages();
  }

  std::uint32_t blocks() const override { return 1; }

  Payload read(std::uint32_t, std::uint64_t offset, std::uint32_t) const override {
    const std::lock_guard lock(mutex_);
    const auto id = static_cast<sqlite3_int64>(offset);
    int result = SQLITE_OK;
    if (blob_) {
      result = sqlite3_blob_reopen(blob_.get(), id);
    } else {
      sqlite3_blob* opened = nullptr;
      result = sqlite3_blob_open(database_.get(), "main", "messages", "data", id, 0, &opened);
      blob_.reset(opened);
    }
    if (result == SQLITE_OK) {
      const auto count = static_cast<std::size_t>(sqlite3_blob_bytes(blob_.get()));
      auto bytes = std::make_shared_for_overwrite<std::byte[]>(count);
      result = sqlite3_blob_read(blob_.get(), bytes.get(), static_cast<int>(count), 0);
      if (result == SQLITE_OK) return {bytes, {bytes.get(), count}};
    }
    // One that failed to open can never be used again.
    blob_.reset();
    const bool shorter = result == SQLITE_IOERR;
    fail(shorter ? ErrorCode::truncatedFile : ErrorCode::corruptFile,
         "{}: message {} cannot be read ({}); copy the file again", name_, id,
         shorter ? "the file has become shorter" : sqlite3_errstr(result));
  }

 private:
  void open();
  void run(const char* sql) { sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr); }
  Statement prepare(const char* sql) const;
  void readTopics();
  void readMessages();
  [[noreturn]] void failOpening() const;

  SqliteBytes bytes_;
  SqliteDatabase database_;
  mutable std::mutex mutex_;
  mutable Blob blob_;
  std::unordered_map<sqlite3_int64, std::uint32_t> topicOfId_;
};

void SqlitePart::failOpening() const {
  const int code = sqlite3_errcode(database_.get());
  const bool damaged = code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
  fail(damaged ? ErrorCode::malformedFile : ErrorCode::unsupportedFile,
       "{}: no bag of rosbag2, or damaged ({}); copy the file again", name_,
       printable(sqlite3_errmsg(database_.get())));
}

void SqlitePart::open() {
  database_ = bytes_.open();
  sqlite3* opened = database_.get();
  sqlite3_extended_result_codes(opened, 0);
  sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, static_cast<int>(maxBlockBytes));
  sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  run("PRAGMA cell_size_check = ON");
  if (sqlite3_exec(opened, "SELECT 1 FROM sqlite_master", nullptr, nullptr, nullptr) == SQLITE_CORRUPT) {
    // SQLite does not open a file that is shorter than its header declares, unless one is about to mend it.
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 0, nullptr);
    run("PRAGMA writable_schema = ON");
    warnings.push_back(fmt::format("{}: it is cut off or damaged; what can be read of it is used", name_));
  }
}

Statement SqlitePart::prepare(const char* sql) const {
  sqlite3_stmt* made = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql, -1, &made, nullptr) != SQLITE_OK) failOpening();
  return Statement(made);
}

void SqlitePart::readTopics() {
  // A view, a virtual table or a column that is computed would run what a stranger wrote.
  const Statement tables = prepare(
      "SELECT count(*) FROM sqlite_master AS t WHERE type = 'table' AND name IN ('topics', 'messages')"
      " AND sql LIKE 'CREATE TABLE%'"
      " AND NOT EXISTS (SELECT 1 FROM pragma_table_xinfo(t.name) WHERE hidden > 0)");
  if (sqlite3_step(tables.get()) != SQLITE_ROW) failOpening();
  if (sqlite3_column_int(tables.get(), 0) != 2)
    fail(ErrorCode::unsupportedFile, "{}: an SQLite file without rosbag2's tables; give a bag", name_);
  const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics");
  int result = SQLITE_OK;
  while ((result = sqlite3_step(rows.get())) == SQLITE_ROW)
    topicOfId_.emplace(sqlite3_column_int64(rows.get(), 0),
                       topicNumber(textAt(rows.get(), 1), textAt(rows.get(), 2), textAt(rows.get(), 3)));
  if (result == SQLITE_DONE) return;
  if (topics.empty()) failOpening();
  warnings.push_back(fmt::format("{}: its table of topics is damaged; {} were found", name_, topics.size()));
}

void SqlitePart::readMessages() {
  const Statement rows =
      prepare("SELECT rowid, topic_id, timestamp FROM messages WHERE rowid > ?1 ORDER BY rowid");
  sqlite3_int64 last = 0, skip = 0;
  std::uint64_t unknown = 0, gaps = 0;
  int result = SQLITE_OK;
  // A damaged page is jumped over, however many messages it held.
  for (; result != SQLITE_DONE && skip < longestGap; skip = skip == 0 ? 1 : skip * 2) {
    sqlite3_reset(rows.get());
    sqlite3_bind_int64(rows.get(), 1, last + skip);
    while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) {
      const sqlite3_int64 id = sqlite3_column_int64(rows.get(), 0);
      // A page that is its own child would go round forever.
      if (id <= last || id > std::numeric_limits<sqlite3_int64>::max() - longestGap) break;
      last = id;
      skip = 0;
      const auto topic = topicOfId_.find(sqlite3_column_int64(rows.get(), 1));
      if (topic == topicOfId_.end())
        ++unknown;
      else
        addPlace({sqlite3_column_int64(rows.get(), 2), static_cast<std::uint64_t>(id), 0, topic->second});
    }
    if (result != SQLITE_DONE && skip == 0) ++gaps;
  }
  if (gaps > 0)
    warnings.push_back(
        fmt::format("{}: pages of it are damaged or missing, and the messages on them: {} were found", name_,
                    places.size()));
  if (unknown > 0)
    warnings.push_back(fmt::format("{}: {} messages of unknown topics are left out", name_, unknown));
}

}  // namespace

std::unique_ptr<BagPart> openSqlitePart(FileBytes file) {
  return std::make_unique<SqlitePart>(std::move(file));
}

}  // namespace estancia::ros
