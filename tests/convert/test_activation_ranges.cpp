// Tables of activation ranges: written and read back, bad lines refused; ranges found by counting.
// SPDX-License-Identifier: Apache-2.0
#include "convert/activation_ranges.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "convert/calibration.hpp"
#include "support/errors.hpp"

namespace estancia::convert {
namespace {

using test::FailsWith;

TEST(ActivationRanges, AreReadAsTheyWereWritten) {
  const test::ScratchFolder scratch;
  const ActivationRanges ranges{{"a value", {-0.1F, 1.0F / 3}}, {"t1", {0, 6.02e23F}}, {"z", {0, 0}}};
  test::writeFile(scratch / "ranges.txt", rangesText(ranges, "of a test"));
  EXPECT_EQ(readRanges(scratch / "ranges.txt"), ranges);
}

TEST(ActivationRanges, RefuseWhatIsNoTable) {
  const test::ScratchFolder scratch;
  const auto read = [&](const std::string& text) {
    test::writeFile(scratch / "r.txt", text);
    return test::caught([&] { readRanges(scratch / "r.txt"); });
  };
  for (const char* line : {"0 1", "0 1 ", "x 1 t", "0 nan t", "0 inf t", "1"})
    EXPECT_THAT(read("# of a test\n" + std::string(line) + "\n"), FailsWith(ErrorCode::malformedFile))
        << line;
  EXPECT_THAT(read("0.5 1 t\n"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(read("0 1 t\n0 2 t\n"), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT([&] { readRanges(scratch / "none.txt"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST(ValueHistogram, CutsOffASingleOutlier) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::vector<float> numbers(200'000);
  for (float& number : numbers) number = std::abs(normal(random));
  numbers[7] = 12;
  ValueHistogram histogram;
  histogram.add(numbers);
  EXPECT_EQ(histogram.range().low, 0);
  EXPECT_LT(histogram.range().high, 10);
  EXPECT_GT(histogram.range().high, 3);
}

TEST(ValueHistogram, TakesWhatIsNotFiniteForZero) {
  const std::vector<float> odd{std::numeric_limits<float>::quiet_NaN(),
                               std::numeric_limits<float>::infinity(), 0, 1};
  ValueHistogram histogram;
  EXPECT_EQ(histogram.range(), ActivationRange());
  histogram.add(odd);
  EXPECT_NEAR(histogram.range().high, 1, 1e-3);
}

}  // namespace
}  // namespace estancia::convert
