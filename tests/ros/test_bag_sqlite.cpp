// rosbag2's SQLite files: nothing is written beside them, and what is in them is not trusted.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>

#include "ros/bag_contents.hpp"
#include "ros/bag_writer.hpp"
#include "support/errors.hpp"

namespace estancia::ros {
namespace {

namespace fs = std::filesystem;
using test::contentsOf;
using test::FailsWith;
using testing::IsEmpty;

std::vector<test::WrittenMessage> sqliteDrive() {
  const std::string cdr("\0\1\0\0", 4);
  std::vector<test::WrittenMessage> messages;
  for (int i = 0; i < 40; ++i)
    messages.push_back(
        {i % 4 == 0 ? "/tf" : "/image", i % 4 == 0 ? "tf2_msgs/msg/TFMessage" : "sensor_msgs/msg/Image",
         1'500'000'000'000'000'000 + i, cdr + std::string(50 + i * 200, static_cast<char>('a' + i % 26))});
  return messages;
}

void change(const fs::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(database);
  sqlite3_close(database);
}

class SqliteBag : public testing::Test {
 protected:
  void SetUp() override { test::writeSqliteBag(path_, sqliteDrive()); }
  test::ScratchFolder folder_;
  /// A name that would mean something in a URI.
  fs::path path_ = folder_ / "drive 100%?mode=rw#1.db3";
};

TEST_F(SqliteBag, IsReadAndLeftAsItIs) {
  const std::string before = test::readFile(path_);
  {
    const auto bag = openBag(path_);
    EXPECT_TRUE(isBag(path_));
    EXPECT_THAT(bag->warnings(), IsEmpty());
    EXPECT_EQ(contentsOf(*bag).size(), 40U);
    EXPECT_EQ(bag->topics()[1].type, "tf2_msgs/TFMessage");
    EXPECT_EQ(bag->topics()[1].encoding, Encoding::cdr);
    EXPECT_EQ(test::bytesOf(*bag, 39), sqliteDrive()[39].bytes);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);
  EXPECT_EQ(test::readFile(path_), before);
}

TEST_F(SqliteBag, MessagesThatWaitBesideItAreTold) {
  change(path_, "PRAGMA journal_mode = WAL");
  test::writeFile(path_.string() + "-wal", std::string(100, 'w'));
  const auto bag = openBag(path_);
  EXPECT_EQ(bag->warnings().size(), 1U);
  EXPECT_EQ(contentsOf(*bag).size(), 40U);
}

TEST_F(SqliteBag, MessagesOfNoTopicAreTold) {
  change(path_, "DELETE FROM topics WHERE name = '/tf'");
  const auto bag = openBag(path_);
  EXPECT_EQ(bag->warnings().size(), 1U);
  EXPECT_EQ(contentsOf(*bag).size(), 30U);
}

TEST_F(SqliteBag, ADamagedPageCostsItsMessagesOnly) {
  std::string bytes = test::readFile(path_);
  // Each page that begins as a leaf of a table; pages of this file have 4096 bytes.
  std::size_t leaves = 0, survived = 0;
  for (std::size_t page = 1; page < bytes.size() / 4096; ++page) {
    if (bytes[page * 4096] != 13) continue;
    std::string damaged = bytes;
    std::fill_n(damaged.begin() + static_cast<std::ptrdiff_t>(page * 4096), 4096, '\xEE');
    test::writeFile(path_, damaged);
    std::unique_ptr<Bag> bag;
    test::caught([&] { bag = openBag(path_); });
    if (!bag) continue;  // the page of the topics
    ++leaves;
    std::size_t unreadable = 0;
    const std::size_t found = contentsOf(*bag, &unreadable).size();
    SCOPED_TRACE(page);
    EXPECT_LT(found, 40U);
    EXPECT_FALSE(bag->warnings().empty());
    if (found > 0) ++survived;
  }
  EXPECT_GT(leaves, 5U);
  EXPECT_EQ(survived, leaves);
}

TEST_F(SqliteBag, WhatIsNoneIsRefused) {
  for (const char* sql :
       {"ALTER TABLE messages RENAME TO hidden;"
        "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
        " SELECT i AS id, 1 AS topic_id, i AS timestamp, 'x' AS data FROM n",
        "ALTER TABLE topics ADD COLUMN computed TEXT AS (hex(zeroblob(1000000)))", "DROP TABLE topics"}) {
    fs::remove(path_);
    test::writeSqliteBag(path_, sqliteDrive());
    change(path_, sql);
    EXPECT_THAT([&] { openBag(path_); }, FailsWith(ErrorCode::unsupportedFile)) << sql;
  }
  test::writeFile(path_, std::string("SQLite format 3\0", 16) + std::string(5000, '\x77'));
  EXPECT_THAT([&] { openBag(path_); }, FailsWith(ErrorCode::malformedFile));
  test::writeFile(path_, std::string("SQLite format 3\0", 16));
  EXPECT_THAT([&] { openBag(path_); }, FailsWith(ErrorCode::malformedFile));
}

}  // namespace
}  // namespace estancia::ros
