// Frame samples: which frames of a place stay when not all of them fit.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/session/frame_sample.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace estancia {
namespace {

using Entry = FrameSample::Entry;

/// Frames first … end − 1 of a node, of 100 bytes each.
std::vector<Entry> framesOf(int node, std::size_t first, std::size_t end, double information = 1) {
  std::vector<Entry> entries;
  for (std::size_t i = first; i < end; ++i)
    entries.push_back({i, node, FrameSample::keyOf(i, information), 100, false});
  return entries;
}

std::vector<Entry> operator+(std::vector<Entry> a, const std::vector<Entry>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Without those that are gone.
std::map<int, std::size_t> countsOf(const std::vector<Entry>& entries, const std::vector<std::size_t>& gone) {
  std::map<int, std::size_t> counts;
  for (const Entry& entry : entries)
    if (!std::ranges::binary_search(gone, entry.frame)) ++counts[entry.node];
  return counts;
}

TEST(FrameSample, TakesAllUntilItIsThinned) {
  const FrameSample sample;
  for (std::size_t i = 0; i < 100; ++i) EXPECT_TRUE(sample.takes(3, FrameSample::keyOf(i, 0.05)));
}

TEST(FrameSample, TheLargestPlacesGiveFirst) {
  FrameSample sample;
  const auto entries = framesOf(0, 0, 10) + framesOf(1, 10, 110) + framesOf(2, 110, 1110);
  const auto gone = sample.thin(entries, 4000);
  ASSERT_TRUE(gone);
  EXPECT_EQ(countsOf(entries, *gone), (std::map<int, std::size_t>{{0, 10}, {1, 15}, {2, 15}}));
  EXPECT_TRUE(sample.takes(0, 1e9)) << "a place with few frames takes all";
}

TEST(FrameSample, IsTheSameWhetherFramesComeBeforeOrAfterItIsThinned) {
  FrameSample early, late;
  const auto begin = framesOf(0, 0, 400);
  std::set<std::size_t> kept;
  const auto gone = early.thin(begin, 100 * 50);
  ASSERT_TRUE(gone);
  std::vector<Entry> stream;
  for (const Entry& entry : begin)
    if (!std::ranges::binary_search(*gone, entry.frame)) stream.push_back(entry);
  for (const Entry& entry : framesOf(0, 400, 1000))
    if (early.takes(0, entry.key)) stream.push_back(entry);
  EXPECT_LT(stream.size(), 50 + 600 / 4);
  const auto laterGone = early.thin(stream, 100 * 50);
  ASSERT_TRUE(laterGone);
  for (const Entry& entry : stream)
    if (!std::ranges::binary_search(*laterGone, entry.frame)) kept.insert(entry.frame);
  const auto all = framesOf(0, 0, 1000);
  const auto goneAtOnce = late.thin(all, 100 * 50);
  ASSERT_TRUE(goneAtOnce);
  std::set<std::size_t> atOnce;
  for (const Entry& entry : all)
    if (!std::ranges::binary_search(*goneAtOnce, entry.frame)) atOnce.insert(entry.frame);
  EXPECT_EQ(kept, atOnce);
}

TEST(FrameSample, KeepsWhatSaysMoreMoreOften) {
  FrameSample sample;
  auto entries = framesOf(0, 0, 20000, 1) + framesOf(0, 20000, 40000, 0.1);
  const auto gone = sample.thin(entries, 100 * 2000);
  ASSERT_TRUE(gone);
  std::size_t dull = 0;
  for (std::size_t i = 20000; i < 40000; ++i) dull += !std::ranges::binary_search(*gone, i);
  EXPECT_NEAR(static_cast<double>(dull) / 2000, 0.1 / 1.1, 0.02);  // of few that stay, in the ratio of rates
}

TEST(FrameSample, NeededFramesStay) {
  FrameSample sample;
  auto entries = framesOf(0, 0, 1000);
  for (std::size_t i = 0; i < 1000; i += 50) entries[i].isNeeded = true;
  const auto gone = sample.thin(entries, 100 * 40);
  ASSERT_TRUE(gone);
  for (std::size_t i = 0; i < 1000; i += 50) EXPECT_FALSE(std::ranges::binary_search(*gone, i));
  EXPECT_LE(1000 - gone->size(), 40U);
  EXPECT_GE(1000 - gone->size(), 35U);
}

TEST(FrameSample, SaysWhenOneFrameAPlaceDoesNotFit) {
  FrameSample sample;
  std::vector<Entry> entries;
  for (int node = 0; node < 20; ++node)
    entries =
        entries + framesOf(node, static_cast<std::size_t>(node) * 5, static_cast<std::size_t>(node) * 5 + 5);
  EXPECT_FALSE(sample.thin(entries, 1999));
  const auto gone = sample.thin(entries, 2000);
  ASSERT_TRUE(gone);
  for (const auto& [node, count] : countsOf(entries, *gone)) EXPECT_EQ(count, 1U) << node;
}

TEST(FrameSample, GoesOnFromItsState) {
  FrameSample sample, resumed;
  ASSERT_TRUE(sample.thin(framesOf(7, 0, 100), 1000));
  const std::string state = sample.state();
  ByteReader in(state, "a sample", "none");
  resumed.restore(in);
  std::size_t taken = 0;
  for (std::size_t i = 100; i < 300; ++i) {
    EXPECT_EQ(sample.takes(7, FrameSample::keyOf(i, 1)), resumed.takes(7, FrameSample::keyOf(i, 1)));
    taken += resumed.takes(7, FrameSample::keyOf(i, 1));
  }
  EXPECT_LT(taken, 60U);
  EXPECT_GT(taken, 3U);
}

}  // namespace
}  // namespace estancia
