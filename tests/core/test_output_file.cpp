// Files of our own: written whole or not at all, their bytes, base64 and PNG, which OpenCV's codec checks.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/base64.hpp"
#include "estancia/core/module_function.hpp"
#include "estancia/core/png.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "estancia/core/bytes.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/image_codecs.hpp"
#include "estancia/core/output_file.hpp"
#include "support/errors.hpp"
#include "support/images.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using testing::ElementsAre;

std::size_t filesIn(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(WriteWhole, ReplacesAFileButNoFolderAndLeavesNothingBeside) {
  const test::ScratchFolder folder;
  writeWhole(folder / "a.json", "first");
  writeWhole(folder / "a.json", std::string("se\0cond", 7));
  EXPECT_EQ(test::readFile(folder / "a.json"), std::string("se\0cond", 7));
  EXPECT_EQ(filesIn(folder.path()), 1U);
  EXPECT_THAT([&] { writeWhole(folder.path(), "x"); }, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_THAT([&] { writeWhole(folder / "none/a.json", "x"); }, FailsWith(ErrorCode::fileUnwritable));
  EXPECT_EQ(filesIn(folder.path()), 1U);
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
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit full{1000, before.rlim_max};  // for this process the same as a full disk
  setrlimit(RLIMIT_FSIZE, &full);
  const auto told = test::caught([&] { writeWhole(folder / "a.json", std::string(100000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(told, FailsWith(ErrorCode::fileUnwritable));
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

TEST(Bytes, AreReadAsTheyWereWrittenInLittleEndianWithCountsBeforeLists) {
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
  ByteWriter few;
  few.number<std::uint16_t>(0x0102);
  few.text("é");
  few.numbers(std::vector<std::uint8_t>{7});
  EXPECT_EQ(few.bytes(), std::string("\x02\x01"
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

TEST(Base64, IsThatOfTheStandardAndNothingElse) {
  EXPECT_EQ(toBase64(""), "");
  EXPECT_EQ(toBase64("f"), "Zg==");
  EXPECT_EQ(toBase64("foob"), "Zm9vYg==");
  EXPECT_EQ(toBase64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(fromBase64("Zm9vYmFy"), "foobar");
  EXPECT_EQ(fromBase64("Zm9vYg=="), std::string("foob\0\0", 6)) << "padding becomes zeros";
  EXPECT_FALSE(fromBase64("Zm9v!mFy"));
  EXPECT_FALSE(fromBase64("Zm9vY"));
}

const cv::Size kMost{1000, 1000};

/// Any values, the same each time.
cv::Mat noise(cv::Size size, int type) {
  cv::Mat image(size, type);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 65536, true);
  return image;
}

bool isSame(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Png, LosesNothingAndReadsWhatOthersWrite) {
  for (const int type : {CV_8U, CV_16U, CV_8UC3, CV_16UC3, CV_8UC4, CV_16UC4})
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(37, 21), cv::Size(3, 300)}) {
      const cv::Mat image = noise(size, type);
      EXPECT_TRUE(isSame(cv::imdecode(toPng(image), cv::IMREAD_UNCHANGED), image)) << type << size;
      EXPECT_EQ(isSame(fromPng(toPng(image), size), image), image.channels() == 1) << type << size;
    }
  for (const int type : {CV_8U, CV_16U}) {
    const cv::Mat image = noise({37, 21}, type);
    std::vector<unsigned char> png;
    cv::imencode(".png", image, png);
    EXPECT_TRUE(isSame(fromPng(png, kMost), image)) << type;
  }
}

TEST(Png, DecodesNothingLargerThanAllowedOrDamaged) {
  const auto png = toPng(noise({37, 21}, CV_8U));
  EXPECT_FALSE(fromPng(png, {37, 21}).empty());
  EXPECT_TRUE(fromPng(png, {36, 21}).empty());
  EXPECT_TRUE(fromPng(png, {37, 20}).empty());
  EXPECT_TRUE(fromPng(png, {0, 0}).empty());
  EXPECT_TRUE(fromPng(png, {-1, -1}).empty());
  const auto whole = toPng(noise({37, 21}, CV_16U));
  for (std::size_t length = 0; length < whole.size(); length += 5)
    EXPECT_TRUE(fromPng({whole.data(), length}, kMost).empty()) << length;
  for (std::size_t at = 0; at < whole.size(); at += 3) {
    auto damaged = whole;
    damaged[at] ^= 0x41;
    EXPECT_TRUE(fromPng(damaged, kMost).empty()) << at;
  }
  for (const cv::Mat& image : {cv::Mat(), cv::Mat(4, 4, CV_32F, cv::Scalar(1)),
                               cv::Mat(4, 4, CV_8UC2, cv::Scalar(1)), cv::Mat(4, 4, CV_16S, cv::Scalar(1))})
    EXPECT_THAT([&] { toPng(image); }, FailsWith(ErrorCode::invalidInput));
}

TEST(ModuleFunction, IsFoundOrItsModuleIsMissing) {
  EXPECT_THAT([] { getModuleFunction("libnowhere.so", "../lib", "f", "stars cannot be counted"); },
              FailsWith(ErrorCode::missingDependency));
  EXPECT_THAT([] { getModuleFunction("libm.so.6", "../lib", "nonesuch", "nothing works"); },
              FailsWith(ErrorCode::missingDependency));
  EXPECT_NE(getModuleFunction("libm.so.6", "../lib", "cos", "nothing works"), nullptr);
  EXPECT_THAT([] { getModuleFunction("libnowhere.so", "../lib", "f", "nothing works", "stars-dev"); },
              FailsWith(ErrorCode::missingDependency));
}

TEST(ImageCodecs, MayBeOpenedBySeveralThreadsAtOnce) {
  const cv::Mat gray(8, 8, CV_8UC3, cv::Scalar::all(90));
  std::array<double, 4> worst{};
  test::inThreads(4, [&](int t) {
    const auto jpeg = imageCodecs().encodeJpeg(gray, 95);
    worst[static_cast<std::size_t>(t)] =
        cv::norm(imageCodecs().decode(jpeg, DecodedAs::color), gray, cv::NORM_INF);
  });
  for (const double difference : worst) EXPECT_LE(difference, 1);
  EXPECT_TRUE(imageCodecs().decode(std::array<unsigned char, 3>{1, 2, 3}, DecodedAs::stored).empty());
}

}  // namespace
}  // namespace estancia
