// SPDX-License-Identifier: Apache-2.0
#include "estancia/report/measures.hpp"

#include "estancia/query/accuracy.hpp"
#include "estancia/query/quality.hpp"
#include "estancia/zones/measure.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace estancia {
namespace {

std::ptrdiff_t placeOf(const std::vector<Measure>& measures, const std::string& key) {
  const auto found = std::find_if(measures.begin(), measures.end(),
                                  [&key](const Measure& measure) { return measure.key == key; });
  return found == measures.end() ? -1 : found - measures.begin();
}

template <typename Quality>
void expectRoomsToBeCounted() {
  Quality quality;
  EXPECT_EQ(placeOf(measuresOf(quality), "frames_with_room"), -1);
  EXPECT_GT(placeOf(measuresOf(quality), "v_measure"), 0) << "unknown, but not left out";
  quality.framesWithRoom = 3;
  quality.rooms = Agreement{};
  const auto measures = measuresOf(quality);
  const auto frames = placeOf(measures, "frames_with_room");
  ASSERT_GT(frames, 0);
  EXPECT_EQ(measures.at(static_cast<std::size_t>(frames)).value, 3);
  EXPECT_EQ(placeOf(measures, "v_measure"), frames + 1) << "it tells of the next five";
  EXPECT_EQ(placeOf(measures, "purity"), frames + 5);
  EXPECT_EQ(placeOf(measures, "seen_purity"), -1) << "not known by most";
  quality.framesWithRoomSeen = 2;
  quality.roomsSeen = Agreement{.purity = 0.5};
  const auto seen = measuresOf(quality);
  const auto purity = placeOf(seen, "seen_purity");
  EXPECT_EQ(placeOf(seen, "frames_with_seen_room"), frames + 6);
  ASSERT_EQ(purity, frames + 11);
  EXPECT_EQ(seen.at(static_cast<std::size_t>(purity)).value, 0.5);
}

TEST(Measures, ImagesWithARoomAreCountedWhereThereAreSome) {
  expectRoomsToBeCounted<MapQuality>();
  expectRoomsToBeCounted<ZoneQuality>();
}

}  // namespace
}  // namespace estancia
