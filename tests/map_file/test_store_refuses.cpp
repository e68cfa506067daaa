// What is no map, or no map to believe: reported by name, and left unchanged.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include "estancia/map_file/store.hpp"
#include "map_file/small_map.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using Access = MapStore::Access;
using test::FailsWith;
using test::filesIn;
using test::identity;
using test::refusal;
using test::smallMap;
using test::tamper;

TEST(MapStoreRefuses, AnExistingPath) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  EXPECT_THAT([&] { MapStore::create(path, identity()); }, FailsWith(ErrorCode::fileExists));
  fs::create_symlink(path.filename(), folder / "link.estancia");
  EXPECT_THAT([&] { MapStore::create(folder / "link.estancia", identity()); },
              FailsWith(ErrorCode::fileExists));
}

TEST(MapStoreRefuses, APathThatSomebodyElseTookMeanwhile) {
  const test::ScratchFolder folder;
  MapStore store = MapStore::create(folder / "map.estancia", identity());
  test::writeFile(folder / "map.estancia", "precious");
  EXPECT_THAT([&] { store.commit(); }, FailsWith(ErrorCode::fileExists));
  EXPECT_EQ(test::readFile(folder / "map.estancia"), "precious");
  EXPECT_THAT(filesIn(folder.path()), testing::ElementsAre("map.estancia"));
  EXPECT_THAT([&] { store.putState("a", "b"); }, FailsWith(ErrorCode::invalidState));
}

TEST(MapStoreRefuses, WhatIsNoMapAndLeavesItAlone) {
  const test::ScratchFolder folder;
  const std::string text(5000, 'x');
  test::writeFile(folder / "text.estancia", text);
  test::writeFile(folder / "short.estancia", "hello");
  test::writeFile(folder / "empty.estancia", "");
  fs::create_symlink("link.estancia", folder / "link.estancia");
  tamper(folder / "other.db", "CREATE TABLE songs(name TEXT)");
  const std::string other = test::readFile(folder / "other.db");
  const std::pair<fs::path, ErrorCode> cases[] = {{folder / "no.estancia", ErrorCode::fileNotFound},
                                                  {folder / "link.estancia", ErrorCode::fileUnreadable},
                                                  {folder.path(), ErrorCode::unsupportedFile},
                                                  {"/dev/null", ErrorCode::unsupportedFile},
                                                  {folder / "text.estancia", ErrorCode::unsupportedFile},
                                                  {folder / "short.estancia", ErrorCode::truncatedFile},
                                                  {folder / "empty.estancia", ErrorCode::truncatedFile},
                                                  {folder / "other.db", ErrorCode::unsupportedFile}};
  for (const Access access : {Access::read, Access::write})
    for (const auto& [path, code] : cases) EXPECT_THAT(refusal(path, access), FailsWith(code)) << path;
  EXPECT_EQ(test::readFile(folder / "text.estancia"), text);
  EXPECT_EQ(test::readFile(folder / "other.db"), other);

  const fs::path path = smallMap(folder);
  ASSERT_EQ(mkfifo((path.string() + "-wal").c_str(), 0600), 0);
  EXPECT_THAT(refusal(path), FailsWith(ErrorCode::unsupportedFile)) << "a pipe beside it";
}

TEST(MapStoreRefuses, OtherFormatsNamingBothVersions) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  for (const char* version : {"1", "3", "9"}) {
    tamper(path, std::string("PRAGMA user_version = ") + version);
    const test::Caught caught = refusal(path);
    EXPECT_THAT(caught,
                FailsWith(ErrorCode::unsupportedFile, std::string("format ") + version, "formats 4 to 6"));
  }
  tamper(path, "PRAGMA user_version = -1");
  EXPECT_THAT(refusal(path), FailsWith(ErrorCode::corruptFile));
}

TEST(MapStoreRefuses, ATruncatedFileAtEveryLength) {
  const test::ScratchFolder folder;
  const std::string whole = test::readFile(smallMap(folder, 40)), longer = whole + "and more";
  ASSERT_GT(whole.size(), 8U * 4096);
  for (const std::size_t length : {std::size_t{99}, std::size_t{600}, std::size_t{4096}, whole.size() / 2,
                                   whole.size() - 1, whole.size() + 1, longer.size()}) {
    const fs::path path = folder / "cut.estancia";
    test::writeFile(path, longer.substr(0, length));
    const ErrorCode expected = length < 512 ? ErrorCode::truncatedFile : ErrorCode::corruptFile;
    EXPECT_THAT(refusal(path), FailsWith(expected, "cut.estancia")) << length;
    EXPECT_THAT(refusal(path, Access::write), FailsWith(expected, "cut.estancia")) << length;
  }
}

TEST(MapStoreRefuses, ChangedBytesUnlessTheMapCanBeReadStill) {
  const test::ScratchFolder folder;
  const std::string whole = test::readFile(smallMap(folder));
  const fs::path path = folder / "changed.estancia";
  for (std::size_t at = 0; at < whole.size(); at += at < 200 ? 1 : 29) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ (at % 2 == 0 ? 0xFF : 0x01));
    test::writeFile(path, changed);
    EXPECT_NE(refusal(path).code, ErrorCode::invalidState) << at;
    EXPECT_EQ(test::readFile(path), changed) << at << ": it is left as it was";
  }
}

TEST(MapStoreRefuses, ContentsThatAreNotToBeBelieved) {
  for (const char* sql : {"UPDATE nodes SET mean = x'0000'",
                          "UPDATE nodes SET sigma = zeroblob(12000000)",
                          "UPDATE nodes SET mean = x'0000c07f0000c07f0000c07f'",
                          "UPDATE nodes SET mean = x'0000a0c00000a0c00000a0c0'",
                          "UPDATE nodes SET id = -5",
                          "UPDATE nodes SET frames = 0",
                          "UPDATE nodes SET id = 1",
                          "UPDATE frames SET node = 99999999999",
                          "UPDATE frames SET node = -1 WHERE id = 1",
                          "UPDATE frames SET node = 7",
                          "UPDATE frames SET id = -1 WHERE id = 0",
                          "INSERT INTO drives VALUES(77, 'a', 'b', 1, 0, 0, 0, 0, 0, 0, 1)",
                          "INSERT INTO drives VALUES(1, 'a', 'b', 2, 0, 0, 0, 0, 0, 0, 1)",
                          "INSERT INTO drives VALUES(1, 'a', 'b', 1, 0, 0, 0, NULL, 0, 0, 1)",
                          "INSERT INTO meta VALUES('parts', '[[1]]')",
                          "DELETE FROM frames WHERE id = 1",
                          "UPDATE frames SET id = 9223372036854775807 WHERE id = 2",
                          "UPDATE frames SET id = id - 9",
                          "UPDATE frames SET id = 1099511627776 WHERE id = 2",
                          "INSERT INTO transitions VALUES(0, 7, 1, 1)",
                          "INSERT INTO transitions VALUES(0, 0, 9223372036854775807, 1)",
                          "UPDATE nodes SET frames = 4",
                          "UPDATE decisions SET kind = 5",
                          "UPDATE decisions SET kind = 1, current = -1",
                          "UPDATE decisions SET frame = 77 WHERE frame = 2",
                          "UPDATE labels SET label = 'cap' WHERE id = 0",
                          "DELETE FROM labels",
                          "UPDATE labels SET id = 8 WHERE id = 1",
                          "DELETE FROM meta WHERE key = 'model'",
                          "DROP TABLE merges",
                          "DROP TABLE frames; CREATE VIEW frames AS SELECT 1"}) {
    const test::ScratchFolder folder;
    const fs::path path = smallMap(folder);
    tamper(path, sql);
    EXPECT_THAT(refusal(path), FailsWith(ErrorCode::corruptFile)) << sql;
  }
}

/// What makes SQLite delete `victim` once it has rolled back by it (file format, 3).
std::string journalNaming(const fs::path& victim, const fs::path& map) {
  constexpr std::size_t sector = 512, page = 4096;
  const auto number = [](std::size_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  const std::string magic = "\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", name = victim.string();
  std::string journal =
      magic + number(0) + number(1) + number(fs::file_size(map) / page) + number(sector) + number(page);
  journal.resize(sector, '\0');
  std::size_t sum = 0;
  for (const char c : name) sum += static_cast<unsigned char>(c);
  return journal + number(0x40000000 / page + 1) + name + number(name.size()) + number(sum) + magic;
}

TEST(MapStoreRefuses, AJournalThatNamesAnotherFile) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder), link = folder / "link.estancia", victim = folder / "precious";
  const fs::path journal = path.string() + "-journal";
  fs::create_symlink(path, link);
  test::writeFile(victim, "precious");
  test::writeFile(journal, journalNaming(victim, path));
  for (const fs::path& name : {path, link}) {
    EXPECT_THAT(refusal(name), FailsWith(ErrorCode::corruptFile));
    EXPECT_TRUE(fs::exists(victim));
  }
  sqlite3* database = nullptr;  // verifies that it is such a journal
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database, "SELECT * FROM frames", nullptr, nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_FALSE(fs::exists(victim));
  EXPECT_EQ(MapStore::open(path, Access::read).frameCount(), 3U);
}

TEST(MapStoreRefuses, SchemasThatCalculate) {
  for (const char* sql :
       {"CREATE TABLE other(a, b AS (zeroblob(9)))",
        "CREATE TABLE other(a, b TEXT DEFAULT (hex(zeroblob(9))))", "CREATE INDEX other ON frames(hex(name))",
        "CREATE INDEX other ON frames(node) WHERE hex(name) = '00'",
        "CREATE VIRTUAL TABLE other USING fts5(a)"}) {
    const test::ScratchFolder folder;
    const fs::path path = smallMap(folder);
    tamper(path, sql);
    EXPECT_THAT(refusal(path), FailsWith(ErrorCode::corruptFile)) << sql;
  }
}

TEST(MapStore, RunsNoConstraintsOfTheFile) {
  const test::ScratchFolder folder;
  const fs::path path = smallMap(folder);
  tamper(path,
         "CREATE TABLE other(key TEXT PRIMARY KEY, bytes BLOB NOT NULL, CHECK(length(bytes) < 0)); "
         "DROP TABLE state; ALTER TABLE other RENAME TO state");
  MapStore store = MapStore::open(path, Access::write);
  EXPECT_NO_THROW(store.putState("key", "bytes"));
}

}  // namespace
}  // namespace estancia
