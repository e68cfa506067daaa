// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/base64.hpp"
#include "estancia/core/bytes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "support/errors.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using testing::ElementsAre;

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

TEST(Bytes, CountsBeyondTheEndAllocateNothing) {
  ByteWriter out;
  out.number(std::numeric_limits<std::uint64_t>::max());
  out.number<std::uint64_t>(0);
  EXPECT_THAT([&] { readerOf(out.bytes()).numbers<double>(); }, FailsWith(ErrorCode::truncatedFile));
  EXPECT_THAT([&] { readerOf(out.bytes()).count(1); }, FailsWith(ErrorCode::truncatedFile));
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
