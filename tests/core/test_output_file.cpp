// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/base64.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "estancia/core/bytes.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using testing::ElementsAre;

std::size_t filesIn(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(WriteWhole, ReplacesAFileAndLeavesNothingBeside) {
  const test::ScratchFolder folder;
  writeWhole(folder / "a.json", "first");
  writeWhole(folder / "a.json", std::string("se\0cond", 7));
  EXPECT_EQ(test::readFile(folder / "a.json"), std::string("se\0cond", 7));
  EXPECT_EQ(filesIn(folder.path()), 1U);
}

TEST(WriteWhole, RefusesAFolderAndAMissingFolder) {
  const test::ScratchFolder folder;
  EXPECT_THAT([&] { writeWhole(folder.path(), "x"); }, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_THAT([&] { writeWhole(folder / "none/a.json", "x"); }, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_EQ(filesIn(folder.path()), 0U);
}

TEST(WriteWhole, NeverTakesThePlaceOfAPipe) {
  const test::ScratchFolder folder;
  const fs::path pipe = folder / "pipe", link = folder / "link";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("pipe", link);
  for (const fs::path& path : {pipe, link})
    EXPECT_THAT([&] { writeWhole(path, "x"); }, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(filesIn(folder.path()), 2U);
}

TEST(WriteWhole, WritesWhereALinkLeads) {
  const test::ScratchFolder folder;
  fs::create_directory(folder / "there");
  fs::create_symlink("there/a.json", folder / "first");
  fs::create_symlink("first", folder / "second");
  for (const char* text : {"new", "replaced"}) {
    writeWhole(folder / "second", text);
    EXPECT_EQ(test::readFile(folder / "there/a.json"), text);
  }
  EXPECT_TRUE(fs::is_symlink(folder / "second"));
  EXPECT_EQ(filesIn(folder / "there"), 1U);
  fs::create_symlink("circle", folder / "circle");
  EXPECT_THAT([&] { writeWhole(folder / "circle", "x"); }, FailsWith(ErrorCode::fileUnwritable));
}

TEST(WriteWhole, KeepsTheOldFileWhenTheDiskIsFull) {
  const test::ScratchFolder folder;
  writeWhole(folder / "a.json", "old");
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};  // for this process the same as a full disk
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      writeWhole(folder / "a.json", std::string(100000, 'x'));
    } catch (const Error&) {
      _exit(0);
    }
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "a full disk must be told";
  EXPECT_EQ(test::readFile(folder / "a.json"), "old");
  EXPECT_EQ(filesIn(folder.path()), 1U);
}

TEST(WriteWhole, RemovesWhatAKilledProcessHasLeft) {
  const test::ScratchFolder folder;
  const fs::path path = folder / "a.json";
  const pid_t child = fork();
  if (child == 0) {
    test::writeFile(partFile(path), "half");
    raise(SIGKILL);
  }
  waitpid(child, nullptr, 0);
  test::writeFile(partFile(folder / "b.json"), "of a process that lives");
  EXPECT_EQ(filesIn(folder.path()), 2U);
  writeWhole(path, "whole");
  EXPECT_EQ(filesIn(folder.path()), 2U);
  EXPECT_TRUE(fs::exists(partFile(folder / "b.json")));
}

ByteReader readerOf(const std::string& bytes) {
  return {bytes, "a.model", "train it again"};
}

TEST(Bytes, AreReadAsTheyWereWritten) {
  ByteWriter out;
  out.number<std::uint32_t>(0x01020304);
  out.number(-0.5);
  out.numbers(std::vector<float>{1, -2});
  out.numbers(std::vector<int>{});
  out.text(std::string("a\0b", 3));
  out.raw("end");
  ByteReader in = readerOf(out.bytes());
  EXPECT_EQ(in.number<std::uint32_t>(), 0x01020304U);
  EXPECT_EQ(in.number<double>(), -0.5);
  EXPECT_THAT(in.numbers<float>(), ElementsAre(1, -2));
  EXPECT_THAT(in.numbers<int>(), ElementsAre());
  EXPECT_EQ(in.text(), std::string("a\0b", 3));
  EXPECT_EQ(in.remaining(), 3U);
  EXPECT_EQ(in.raw(3), "end");
  EXPECT_EQ(in.remaining(), 0U);
}

TEST(Bytes, AreLittleEndianWithCountsBeforeLists) {
  ByteWriter out;
  out.number<std::uint16_t>(0x0102);
  out.text("é");
  out.numbers(std::vector<std::uint8_t>{7});
  EXPECT_EQ(out.bytes(), std::string("\x02\x01"
                                     "\x02\0\0\0"
                                     "\xC3\xA9"
                                     "\x01\0\0\0\0\0\0\0"
                                     "\x07",
                                     17));
}

TEST(Bytes, EveryTruncationIsRefused) {
  ByteWriter out;
  out.number<std::uint32_t>(5);
  out.numbers(std::vector<double>{1, 2});
  out.text("word");
  for (std::size_t size = 0; size < out.bytes().size(); ++size)
    EXPECT_THAT(
        [&] {
          const std::string bytes = out.bytes().substr(0, size);
          ByteReader in = readerOf(bytes);
          in.number<std::uint32_t>();
          in.numbers<double>();
          in.text();
        },
        FailsWith(ErrorCode::truncatedFile))
        << size;
}

TEST(Base64, IsThatOfTheStandard) {
  EXPECT_EQ(toBase64(""), "");
  EXPECT_EQ(toBase64("f"), "Zg==");
  EXPECT_EQ(toBase64("foob"), "Zm9vYg==");
  EXPECT_EQ(toBase64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(fromBase64("Zm9vYmFy"), "foobar");
  EXPECT_EQ(fromBase64("Zm9vYg=="), std::string("foob\0\0", 6)) << "padding becomes zeros";
}

TEST(Base64, RefusesOtherText) {
  EXPECT_FALSE(fromBase64("Zm9v!mFy"));
  EXPECT_FALSE(fromBase64("Zm9vY"));
}

}  // namespace
}  // namespace estancia
