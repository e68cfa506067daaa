// PNG files of our own, checked by OpenCV's codec.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/png.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;

const cv::Size kMost{1000, 1000};

/// Any values, the same each time.
cv::Mat noise(cv::Size size, int type) {
  cv::Mat image(size, type);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 65536, true);
  return image;
}

std::uint32_t crc32(const std::vector<unsigned char>& bytes) {
  std::uint32_t sum = ~0U;
  for (const unsigned char byte : bytes) {
    sum ^= byte;
    for (int bit = 0; bit < 8; ++bit) sum = (sum >> 1) ^ ((sum & 1) != 0 ? 0xEDB88320U : 0);
  }
  return ~sum;
}

/// The file with a chunk before its pixels.
std::vector<unsigned char> withChunk(std::vector<unsigned char> png, const std::string& type,
                                     const std::vector<unsigned char>& data) {
  constexpr std::size_t header = 33;  // the file's first bytes and IHDR
  std::vector<unsigned char> chunk(type.begin(), type.end());
  chunk.insert(chunk.end(), data.begin(), data.end());
  const auto bigEndian = [](std::size_t number) {
    return std::array{static_cast<unsigned char>(number >> 24), static_cast<unsigned char>(number >> 16),
                      static_cast<unsigned char>(number >> 8), static_cast<unsigned char>(number)};
  };
  const auto length = bigEndian(data.size());
  const auto sum = bigEndian(crc32(chunk));
  chunk.insert(chunk.begin(), length.begin(), length.end());
  chunk.insert(chunk.end(), sum.begin(), sum.end());
  png.insert(png.begin() + header, chunk.begin(), chunk.end());
  return png;
}

bool isSame(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(Png, LosesNothing) {
  for (const int type : {CV_8U, CV_16U, CV_8UC3, CV_16UC3, CV_8UC4, CV_16UC4})
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(37, 21), cv::Size(3, 300)}) {
      const cv::Mat image = noise(size, type);
      EXPECT_TRUE(isSame(cv::imdecode(toPng(image), cv::IMREAD_UNCHANGED), image)) << type << size;
      EXPECT_EQ(isSame(fromPng(toPng(image), size), image), image.channels() == 1) << type << size;
    }
}

TEST(Png, WritesAPartOfAnImage) {
  const cv::Mat part = noise({40, 30}, CV_16U)(cv::Rect(5, 6, 7, 8));
  EXPECT_TRUE(isSame(fromPng(toPng(part), kMost), part));
}

TEST(Png, ReadsWhatOthersWrite) {
  for (const int type : {CV_8U, CV_16U}) {
    const cv::Mat image = noise({37, 21}, type);
    std::vector<unsigned char> png;
    cv::imencode(".png", image, png);
    EXPECT_TRUE(isSame(fromPng(png, kMost), image)) << type;
  }
}

TEST(Png, DecodesNothingLargerThanAllowed) {
  const auto png = toPng(noise({37, 21}, CV_8U));
  EXPECT_FALSE(fromPng(png, {37, 21}).empty());
  EXPECT_TRUE(fromPng(png, {36, 21}).empty());
  EXPECT_TRUE(fromPng(png, {37, 20}).empty());
  EXPECT_TRUE(fromPng(png, {0, 0}).empty());
  EXPECT_TRUE(fromPng(png, {-1, -1}).empty());
}

TEST(Png, NoticesDamage) {
  const auto whole = toPng(noise({37, 21}, CV_16U));
  for (std::size_t length = 0; length < whole.size(); length += 5)
    EXPECT_TRUE(fromPng({whole.data(), length}, kMost).empty()) << length;
  for (std::size_t at = 0; at < whole.size(); at += 3) {
    auto damaged = whole;
    damaged[at] ^= 0x41;
    EXPECT_TRUE(fromPng(damaged, kMost).empty()) << at;
  }
}

TEST(Png, IsGrayForUs) {
  EXPECT_TRUE(fromPng(toPng(noise({4, 4}, CV_8UC3)), kMost).empty());
  std::vector<unsigned char> bits;
  cv::imencode(".png", noise({16, 16}, CV_8U), bits, {cv::IMWRITE_PNG_BILEVEL, 1});
  EXPECT_TRUE(fromPng(bits, kMost).empty()) << "one bit a pixel";
}

TEST(Png, LengthOfAChunkTakesNoMemory) {
  const cv::Mat image = noise({4, 4}, CV_8U);
  std::vector<unsigned char> text(60'000, 'a');
  text[1] = 0;  // after the key
  EXPECT_TRUE(isSame(fromPng(withChunk(toPng(image), "tEXt", text), kMost), image));
  text.resize(70'000, 'a');
  EXPECT_TRUE(fromPng(withChunk(toPng(image), "tEXt", text), kMost).empty());

  rusage before{}, after{};
  auto lies = withChunk(toPng(image), "tEXt", {0, 0, 0, 1});
  lies[33] = 0x6f;  // 1.8 GB
  getrusage(RUSAGE_SELF, &before);
  EXPECT_TRUE(fromPng(lies, kMost).empty());
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100'000) << "kB";
}

TEST(Png, TextsAreNotInflated) {
  const cv::Mat image = noise({4, 4}, CV_8U);
  const std::vector<unsigned char> text{'k', 0, 0, 'n', 'o', ' ', 'z', 'l', 'i', 'b'};
  EXPECT_TRUE(isSame(fromPng(withChunk(toPng(image), "zTXt", text), kMost), image));
}

TEST(Png, RefusesOtherImages) {
  for (const cv::Mat& image : {cv::Mat(), cv::Mat(4, 4, CV_32F, cv::Scalar(1)),
                               cv::Mat(4, 4, CV_8UC2, cv::Scalar(1)), cv::Mat(4, 4, CV_16S, cv::Scalar(1))})
    EXPECT_THAT([&] { toPng(image); }, FailsWith(ErrorCode::invalidInput));
}

}  // namespace
}  // namespace estancia
