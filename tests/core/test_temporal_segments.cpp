// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/temporal_segments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/errors.hpp"

namespace estancia {
namespace {

using testing::ElementsAre;

/// The sizes of the segments of frames of these names.
std::vector<std::size_t> lengths(const std::vector<std::string>& names,
                                 const std::vector<std::string>& places,
                                 const std::vector<double>& times = {}) {
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < names.size(); ++i) {
    Frame& frame = frames.emplace_back();
    frame.name = names[i];
    if (i < times.size()) frame.timestamp = times[i];
  }
  std::vector<std::size_t> sizes;
  std::size_t next = 0;
  for (const TemporalSegment& segment : temporalSegments(frames, places)) {
    EXPECT_EQ(segment.first, next);
    next += segment.size;
    sizes.push_back(segment.size);
  }
  EXPECT_EQ(next, names.size());
  return sizes;
}

std::vector<std::string> all(std::size_t frames) {
  return std::vector<std::string>(frames, "a");
}

TEST(TemporalSegments, EndWhereThePlaceChanges) {
  EXPECT_THAT(lengths({"one.png", "two.png", "three.png", "four.png"}, {"a", "a", "b", "a"}),
              ElementsAre(2, 1, 1));
  EXPECT_THAT(lengths({}, {}), ElementsAre());
}

TEST(TemporalSegments, EndWhereNumbersLeaveMoreOutThanUsual) {
  EXPECT_THAT(lengths({"0001.png", "0002.png", "0003.png", "0005.png", "0006.png"}, all(5)),
              ElementsAre(3, 2));
  EXPECT_THAT(lengths({"frame000001.jpg", "frame000002.jpg", "frame000003.jpg", "frame000009.jpg"}, all(4)),
              ElementsAre(3, 1));
  EXPECT_THAT(lengths({"7.png", "8.png", "9.png", "1.png", "2.png"}, all(5)), ElementsAre(3, 2))
      << "they fall";
}

TEST(TemporalSegments, FractionsAreNoNumbersOfFrames) {
  EXPECT_THAT(lengths({"1305031102.175304.png", "1305031102.211214.png", "1305031102.943223.png",
                       "1305031103.011215.png"},
                      all(4)),
              ElementsAre(4));
  EXPECT_THAT(lengths({"5.275304.png", "5.311214.png", "5.943223.png"}, all(3)), ElementsAre(3))
      << "though the text before the digits is the same";
  EXPECT_THAT(lengths({"t1_x-1.25_a0.7185.jpg", "t2_x-1.26_a0.0012.jpg", "t3_x-1.27_a2.5.jpg"}, all(3)),
              ElementsAre(3));
  EXPECT_THAT(lengths({"1.png", "2.png", "other.png", "90.png"}, all(4)), ElementsAre(4))
      << "not all are numbers";
  const std::string long1(40, '1'), long2(40, '9');
  EXPECT_THAT(lengths({long1, long2}, all(2)), ElementsAre(2)) << "too long for a number";
}

TEST(TemporalSegments, EndWhereTimePasses) {
  // Two rounds of a robot; the clock jitters, and names say nothing.
  EXPECT_THAT(lengths({"9", "3", "7", "1", "2"}, all(5), {0, 0.2, 0.55, 60, 60.2}), ElementsAre(3, 2));
  EXPECT_THAT(lengths({"1", "2", "3", "4"}, all(4), {10, 11, 1, 2}), ElementsAre(2, 2)) << "it falls";
  EXPECT_THAT(lengths({"1", "2", "7", "8"}, all(4), {10, 11, 12}), ElementsAre(2, 2)) << "one has no time";
}

}  // namespace
}  // namespace estancia
